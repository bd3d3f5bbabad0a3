#include "render/environment.h"

#include "components/components.h"
#include "components/light_environment.h"

#include <cglm/cglm.h>
#include <string.h>

bool ng_is_environment(const struct ng_snapshot_light *light)
{
    return light->source.type->component == NG_LIGHT_ENVIRONMENT;
}

void ng_environment_push_of(const struct ng_snapshot_light *light, struct ng_environment_push *out)
{
    struct ng_light_environment environment;
    *out = (struct ng_environment_push){0};
    // Rows of the inverse of a rotation are its columns.
    for (int row = 0; row < 3; row++) {
        vec3 axis = {light->source.matrix[row * 4], light->source.matrix[row * 4 + 1],
                     light->source.matrix[row * 4 + 2]};
        glm_vec3_normalize(axis);
        memcpy(&out->world_to_map[row * 4], axis, sizeof axis);
    }
    memcpy(&environment, light->source.params, sizeof environment);
    for (int c = 0; c < 3; c++)
        out->radiance[c] = environment.color[c] * environment.intensity;
}
