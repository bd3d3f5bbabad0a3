// OpenEXR, as layers and as a picture.
#include "target.h"

#include "asset/exr.h"
#include "asset/image.h"

static ng_result read_layers(const uint8_t *data, size_t size)
{
    struct ng_exr exr;
    NG_TRY(ng_exr_decode("layers.exr", data, size, &(struct ng_exr_limits){.max_memory = 1 << 24}, &exr));
    ng_exr_finish(&exr);
    return NG_OK;
}

static ng_result read_picture(const uint8_t *data, size_t size)
{
    struct ng_image image;
    struct ng_image_params params = {.max_memory = 1 << 24, .repair = true};
    NG_TRY(ng_image_decode("picture.exr", data, size, &params, &image));
    ng_image_finish(&image);
    return NG_OK;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    target_begin();
    target_end(read_layers(data, size));
    target_begin();
    target_end(read_picture(data, size));
    return 0;
}
