// Furniture catalogues: the zip, its properties, and the model of the first piece. What begins with a letter
// is taken for the properties alone, and packed into a zip with a model, so that they need no checksum.
#include "made_files.h"
#include "readers.h"
#include "target.h"

#include "asset/catalogue.h"

#include <stdio.h>

static ng_result list(const char *path)
{
    struct ng_catalogue *catalogue;
    NG_TRY(ng_catalogue_open(path, 1 << 23, &catalogue));
    ng_catalogue_destroy(&catalogue);
    return NG_OK;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bool text = size && (data[0] | 32) >= 'a' && (data[0] | 32) <= 'z' && data[0] != 'P';
    const char *path = target_file("things.sh3f", data, text ? 0 : size);
    char piece[700];
    if (text)
        made_catalogue(path, data, size);
    snprintf(piece, sizeof piece, "%s#1", path);
    target_begin();
    target_end(list(path));
    target_begin();
    target_end(fuzz_read_scene(piece));
    return 0;
}
