/* decoder.c: a decoder in C as a shared library: cc -shared -fPIC -o libmydecoder.so decoder.c mydecoder.c */
#include "mydecoder.h"
#include "snhc_decoder.h"

#include <string.h>

uint32_t snhc_abi_version(void) { return SNHC_ABI_VERSION; }

const char *snhc_describe(void) { return "{\"tools\":[\"fba\"]}"; }

int snhc_decode(const snhc_request *request, snhc_write write, void *context, snhc_rejection *why)
{
    struct mydecoder_fault fault;
    if (mydecoder_run(request->data, request->size, write, context, &fault))
        return SNHC_ACCEPTED;
    strncpy(why->error_class, fault.kind, sizeof why->error_class - 1);
    why->has_bits = 1;
    why->first_bit = fault.first;
    why->end_bit = fault.end;
    return SNHC_REJECTED;
}
