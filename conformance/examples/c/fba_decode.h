/* Decoder of MPEG-4 FBA face streams, arithmetic mode: no globals, one call. */
#ifndef FBA_DECODE_H
#define FBA_DECODE_H

#include <stddef.h>
#include <stdint.h>

enum fba_result {
    FBA_ACCEPTED = 0,
    FBA_REJECTED = 1, /* the error says why */
    FBA_FAILED = 2    /* no memory, or the callback said stop */
};

/* CNF-7, CNF-21: the first fault of a stream; its bits are [first, end). */
struct fba_error {
    const char *error_class;
    const char *rule;
    uint64_t first, end;
};

/* Takes a piece of the output (CNF-1), whole lines; anything but 0 stops the decoder. */
typedef int (*fba_write)(void *user, const char *text, size_t size);

enum fba_result fba_decode(const uint8_t *data, size_t size, fba_write write, void *user, struct fba_error *error);

#endif
