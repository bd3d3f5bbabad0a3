#include "asset/exr.h"
ng_result ng_exr_decode(const char *name, const void *data, size_t size, const struct ng_exr_limits *limits,
                        struct ng_exr *out)
{
    (void)name;
    (void)data;
    (void)size;
    (void)limits;
    (void)out;
    return NG_ERROR_UNSUPPORTED;
}
void ng_exr_finish(struct ng_exr *exr)
{
    (void)exr;
}
const struct ng_exr_plane *ng_exr_plane(const struct ng_exr *exr, const char *name)
{
    (void)exr;
    (void)name;
    return NULL;
}
