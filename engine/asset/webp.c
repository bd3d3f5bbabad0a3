// libwebp, which checks what it reads itself; the size is checked before it decodes anything.
#include "asset/webp.h"
#include "asset/image_internal.h"
#include "base/log.h"

#include <webp/decode.h>

ng_result ng_webp_decode(const char *name, const void *data, size_t size,
                         const struct ng_image_params *params, struct ng_image *out)
{
    WebPBitstreamFeatures features;
    *out = (struct ng_image){0};
    if (WebPGetFeatures(data, size, &features) != VP8_STATUS_OK) {
        ng_log_error("%s: WebP: the header is damaged", name);
        return NG_ERROR_FORMAT;
    }
    if (features.has_animation) {
        ng_log_error("%s: WebP: is an animation; convert it to a picture", name);
        return NG_ERROR_UNSUPPORTED;
    }
    enum ng_pixel_format format = params->srgb ? NG_PIXEL_RGBA8_SRGB : NG_PIXEL_RGBA8;
    NG_TRY(ng_image_allocate(name, (uint32_t)features.width, (uint32_t)features.height, format, params, out));
    if (WebPDecodeRGBAInto(data, size, out->pixels, out->size, features.width * 4))
        return NG_OK;
    ng_log_error("%s: WebP: the data is damaged or ends too early", name);
    ng_image_finish(out);
    return NG_ERROR_FORMAT;
}
