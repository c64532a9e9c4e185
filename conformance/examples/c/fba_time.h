/* Exact times: fractions of any size, kept in lowest terms (FBA-37, FBA-38). */
#ifndef FBA_TIME_H
#define FBA_TIME_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* All denominators divide lcm(1..4095) * 1000, a number of fewer than 1,800 decimal digits. */
enum { TIME_LIMBS = 256, TIME_LIMB = 1000000000 };

struct fba_number {
    size_t used;
    uint32_t limb[TIME_LIMBS]; /* the lowest first, nine decimal digits in each */
};

struct fba_time {
    struct fba_number over, under;
};

void fba_time_set(struct fba_time *time, uint32_t seconds);

/* time += over / under, over below 1.8e10 and under below 2^32, both above 0. False: does not fit. */
bool fba_time_add(struct fba_time *time, uint64_t over, uint32_t under);

/* Writes "p/q" and returns its length; 0 if there is no room. */
size_t fba_time_print(const struct fba_time *time, char *text, size_t room);

#endif
