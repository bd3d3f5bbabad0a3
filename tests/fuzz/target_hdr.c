// Radiance HDR.
#include "target.h"

#include "asset/hdr.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct ng_image image;
    target_begin();
    ng_result result =
        ng_hdr_decode("sky.hdr", data, size, &(struct ng_image_params){.max_memory = 1 << 24}, &image);
    target_end(result);
    if (result == NG_OK)
        ng_image_finish(&image);
    return 0;
}
