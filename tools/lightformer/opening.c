#include "opening.h"

#include "app/stage.h"

const char *const opening_emitters[] = {
    [NG_GLTF_EMITTERS_AUTO] = "auto", [NG_GLTF_EMITTERS_ON] = "on", [NG_GLTF_EMITTERS_OFF] = "off", NULL};

void opening_apply(const struct opening *opening, struct ng_stage_params *params)
{
    params->no_default_light = opening->no_default_light;
    params->emissive_lights = (enum ng_gltf_emitters)opening->emissive_lights;
    params->clip = opening->clip;
}
