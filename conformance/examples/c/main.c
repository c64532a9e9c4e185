/* CNF-9: `fba_decoder INPUT`. 0: accepted, 1: rejected (one JSON line on standard error), 3: files, 2: usage, 70: else. */
#include "fba_decode.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

static int to_stdout(void *user, const char *text, size_t size)
{
    (void)user;
    return fwrite(text, 1, size, stdout) != size;
}

static uint8_t *read_file(const char *name, size_t *size)
{
    FILE *file = fopen(name, "rb");
    if (file == NULL)
        return NULL;
    size_t room = 1 << 16, used = 0;
    uint8_t *data = malloc(room);
    while (data != NULL) {
        used += fread(data + used, 1, room - used, file);
        if (used < room)
            break;
        uint8_t *larger = room > SIZE_MAX / 16 ? NULL : realloc(data, room * 2);
        if (larger == NULL) {
            free(data);
            data = NULL;
        } else {
            data = larger;
            room *= 2;
        }
    }
    if (data != NULL && ferror(file)) {
        free(data);
        data = NULL;
    }
    fclose(file);
    *size = used;
    return data;
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: fba_decoder INPUT\n");
        return 2;
    }
    size_t size = 0;
    uint8_t *data = read_file(argv[1], &size);
    if (data == NULL) {
        fprintf(stderr, "fba_decoder: cannot read %s\n", argv[1]);
        return 3;
    }
    struct fba_error error = {0};
    enum fba_result result = fba_decode(data, size, to_stdout, NULL, &error);
    free(data);
    if (result == FBA_FAILED || fflush(stdout) != 0) {
        fprintf(stderr, "fba_decoder: no memory, or standard output does not take more\n");
        return 70;
    }
    if (result == FBA_REJECTED)
        fprintf(stderr, "{\"class\":\"%s\",\"rule\":\"%s\",\"bits\":[%" PRIu64 ",%" PRIu64 "]}\n", error.error_class,
                error.rule, error.first, error.end);
    return (int)result;
}
