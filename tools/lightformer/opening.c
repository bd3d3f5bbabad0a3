#include "opening.h"

#include "app/stage.h"
#include "base/hash.h"
#include "base/printable.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOST_STOPS 64

const char *const opening_emitters[] = {
    [NG_GLTF_EMITTERS_AUTO] = "auto", [NG_GLTF_EMITTERS_ON] = "on", [NG_GLTF_EMITTERS_OFF] = "off", NULL};

static bool read_exposure(const char *text, struct ng_exposure *out)
{
    *out = (struct ng_exposure){0};
    if (!text)
        return true;
    if (strcmp(text, "auto") == 0) {
        out->mode = NG_EXPOSURE_AUTO;
        return true;
    }
    char *end;
    double stops = strtod(text, &end);
    *out = (struct ng_exposure){.mode = NG_EXPOSURE_FIXED, .factor = (float)exp2(stops)};
    return end != text && *end == 0 && fabs(stops) <= MOST_STOPS;
}

bool opening_check(const struct opening *opening, const char *command)
{
    struct ng_exposure exposure;
    if (read_exposure(opening->exposure, &exposure))
        return true;
    ng_print_line(stderr,
                  "lightformer %s: --exposure: \"%s\" is neither auto nor a number of stops from -%d to %d",
                  command, opening->exposure, MOST_STOPS, MOST_STOPS);
    return false;
}

struct ng_exposure opening_exposure(const struct opening *opening)
{
    struct ng_exposure exposure;
    (void)read_exposure(opening->exposure, &exposure); // it was checked
    exposure.stops = (float)opening->stops;
    return exposure;
}

uint64_t loading_memory(const struct loading *loading)
{
    return (uint64_t)(loading->memory_limit * (1 << 20));
}

void loading_apply(const struct loading *loading, struct ng_stage_params *params)
{
    params->strict = loading->strict;
    params->max_memory = loading_memory(loading);
}

void opening_apply(const struct opening *opening, struct ng_stage_params *params)
{
    loading_apply(&opening->loading, params);
    params->no_default_light = opening->no_default_light;
    params->emissive_lights = (enum ng_gltf_emitters)opening->emissive_lights;
    params->clip = opening->clip;
    params->exposure = opening_exposure(opening);
}

uint64_t opening_hash(const struct opening *opening, uint64_t hash)
{
    if (opening->clip)
        hash = ng_hash_combine(hash, ng_hash_string(opening->clip));
    uint32_t made = opening->emissive_lights << 1 | opening->no_default_light;
    return made ? ng_hash_combine(hash, made) : hash;
}
