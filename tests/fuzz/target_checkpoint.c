// The checkpoint of a reference picture: as it is, and with the checksum of what it holds.
#include "target.h"

#include "made_files.h"

#include "base/hash.h"

#include <stdlib.h>
#include <string.h>

static void read_bytes(const uint8_t *data, size_t size)
{
    const char *path = target_file("samples", data, size);
    target_begin();
    target_end(made_checkpoint_read(path));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    uint64_t hash;
    uint8_t *copy = malloc(size + 1);
    read_bytes(data, size);
    if (copy && size >= sizeof hash) {
        memcpy(copy, data, size);
        hash = ng_hash_bytes(0, copy, size - sizeof hash);
        memcpy(copy + size - sizeof hash, &hash, sizeof hash);
        read_bytes(copy, size);
    }
    free(copy);
    return 0;
}
