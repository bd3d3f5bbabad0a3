#include "method_options.h"

#include "lightformer/methods/methods.h"

#include <string.h>

static const char any[] = "auto";

const char *const method_gbuffers[] = {
    [LF_RAYCAST_AUTO] = any, [LF_RAYCAST_RAYS] = "rays", [LF_RAYCAST_RASTER] = "raster", NULL};

const char *method_option(uint32_t index)
{
    return index == LF_METHODS ? any : lf_method_name(index);
}

const char *method_bench_option(uint32_t index)
{
    for (uint32_t i = 0; i < LF_METHODS; i++)
        if (!lf_method_info(i)->progressive && index-- == 0)
            return lf_method_name(i);
    return index == 0 ? any : NULL;
}

uint32_t method_choose(const char *option, const char *scene, const char *weights)
{
    return lf_method_find(strcmp(option, any) == 0 ? lf_method_default(scene, weights) : option);
}
