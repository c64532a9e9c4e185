/* A decoder as a shared library, checked by `snhc run`. C ABI version 1.
 *
 * The library exports the three functions below. It is loaded in a process of its own: a crash is the status of one
 * vector. Calls come one after another, from one thread. What the library prints on standard output goes to standard
 * error; decoded text is given to `write`.
 *
 * A later version may only append fields: `struct_bytes` says how much of a structure the caller knows.
 */
#ifndef SNHC_DECODER_H
#define SNHC_DECODER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define SNHC_ABI_VERSION 1

/* What snhc_decode returns. Anything else counts as a crash. */
#define SNHC_ACCEPTED 0
#define SNHC_REJECTED 1

#if defined(_WIN32)
#define SNHC_EXPORT __declspec(dllexport)
#else
#define SNHC_EXPORT __attribute__((visibility("default")))
#endif

/* A lowered limit: name as in the guide, e.g. "skipped_frames". */
typedef struct snhc_limit {
    const char *name;
    uint64_t value;
} snhc_limit;

/* A reading of an ambiguity that is to be followed, e.g. "AMB-FBA-6", "before". */
typedef struct snhc_reading {
    const char *ambiguity;
    const char *key;
} snhc_reading;

/* What is to be decoded. All pointers are valid during the call only; texts are UTF-8. */
typedef struct snhc_request {
    size_t struct_bytes;
    const char *media;      /* what the input is: "fba", "m2d", "dctcoef", "fit", "fat", "face" */
    const char *format;     /* what is wanted: "ndjson", "fap" or "csv" */
    const uint8_t *data;
    size_t size;
    const uint8_t *aux;     /* the second input of tools with two, else NULL */
    size_t aux_size;
    int32_t draft;          /* 1: take the start codes of the drafts too */
    int32_t strict;         /* 1: bytes behind the end are an error */
    uint32_t object;        /* number of the object to decode, from 0 */
    uint32_t limit_count;
    const snhc_limit *limits;
    const snhc_reading *readings;
    size_t reading_count;
} snhc_request;

/* Why a stream is rejected. Filled with zeros before the call; all of it may stay so. */
typedef struct snhc_rejection {
    size_t struct_bytes;
    char error_class[32];   /* "MarkerBit", "Truncated", ... ("Unsupported": not applicable) */
    int32_t has_bits;       /* 1: first_bit and end_bit say where, half open, from bit 0 of the input */
    uint32_t line;          /* documents and text: from 1, 0 for none */
    uint64_t first_bit;
    uint64_t end_bit;
    char path[256];         /* documents: e.g. "Graph[3]" */
} snhc_rejection;

/* Takes decoded text, in pieces of any size. Returns 0; anything else: stop and return. */
typedef int (*snhc_write)(void *context, const char *text, size_t length);

/* SNHC_ABI_VERSION of the header that the library was compiled with. */
SNHC_EXPORT uint32_t snhc_abi_version(void);

/* What the decoder can do, as the JSON object of the hello message, e.g.
 * {"name":"my decoder","tools":["fba"],"options":["object"]}. Static storage. */
SNHC_EXPORT const char *snhc_describe(void);

/* Decode one input from the beginning to its end or its first fault. */
SNHC_EXPORT int snhc_decode(const snhc_request *request, snhc_write write, void *context, snhc_rejection *rejection);

#ifdef __cplusplus
}
#endif

#endif
