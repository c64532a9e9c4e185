/* CNF-12: the decoder behind the functions of snhc_decoder.h, for `libfba_decoder.so`. */
#include "../../c/snhc_decoder.h"
#include "fba_decode.h"

#include <string.h>

/* No memory, or the caller takes no more: neither accepted nor rejected. */
#define FAILED 70

uint32_t snhc_abi_version(void)
{
    return SNHC_ABI_VERSION;
}

const char *snhc_describe(void)
{
    return "{\"name\":\"example (C library)\",\"tools\":[\"fba\",\"bap\"]}";
}

int snhc_decode(const snhc_request *request, snhc_write write, void *context, snhc_rejection *rejection)
{
    struct fba_error error = {0};
    switch (fba_decode(request->data, request->size, write, context, &error)) {
    case FBA_ACCEPTED:
        return SNHC_ACCEPTED;
    case FBA_REJECTED:
        strncpy(rejection->error_class, error.error_class, sizeof rejection->error_class - 1);
        rejection->has_bits = 1;
        rejection->first_bit = error.first;
        rejection->end_bit = error.end;
        return SNHC_REJECTED;
    default:
        return FAILED;
    }
}
