// The manifest of a data set.
#include "target.h"

#include "base/file.h"
#include "lightformer/dataset/manifest.h"

#include <stdio.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char folder[512];
    struct lf_manifest manifest;
    const char *path = target_file("manifest.json", data, size);
    snprintf(folder, sizeof folder, "%.*s", (int)(ng_path_name(path) - path), path);
    target_begin();
    ng_result result = lf_manifest_read(folder, &manifest);
    target_end(result);
    if (result == NG_OK)
        lf_manifest_finish(&manifest);
    return 0;
}
