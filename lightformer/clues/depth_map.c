// The nearest texel, without filtering: an occluder's distance mixed with the wall's behind it is neither's.
#include "lightformer/clues/captured.h"

#include <cglm/cglm.h>

static void to_light_frame(const struct ng_light_data *light, const float world[3], float out[3])
{
    vec3 p;
    glm_vec3_sub((float *)world, (float *)light->proxy, p);
    out[0] = glm_vec3_dot(p, (float *)light->look);
    out[1] = glm_vec3_dot(p, (float *)light->right);
    out[2] = glm_vec3_dot(p, (float *)light->up);
}

static bool inside(float x, float y)
{
    return fmaxf(fabsf(x), fabsf(y)) <= 1; // not of a NaN
}

static uint32_t texel(float x, uint32_t size)
{
    uint32_t at = (uint32_t)((x * 0.5f + 0.5f) * (float)size);
    return at < size ? at : size - 1;
}

// Centre of a texel, from -1 to 1.
static float center(uint32_t at, uint32_t size)
{
    return ((float)at + 0.5f) / (float)size * 2 - 1;
}

static float fetch(const struct lf_depth_map *map, uint32_t layer, uint32_t x, uint32_t y)
{
    return map->depth[((size_t)layer * map->face_size + y) * map->face_size + x];
}

// Faces as struct ng_light_data says: the picture of the face along axis k has axis k + 1 to its right and
// axis k + 2 upwards; the opposite face is turned.
static struct lf_shadow_distance look_into_cube(const struct lf_depth_map *map, const float p[3])
{
    const struct ng_light_data *light = map->light;
    struct lf_shadow_distance s;
    s.receiver = s.occluder = glm_vec3_norm((float *)p);
    int k = 0;
    for (int i = 1; i < 3; i++)
        if (fabsf(p[i]) > fabsf(p[k]))
            k = i;
    float along = fabsf(p[k]), side = p[k] < 0 ? -1.0f : 1.0f;
    uint32_t layer = light->layers >> (4 * (k + (p[k] < 0 ? 3 : 0))) & 15;
    float x = p[(k + 1) % 3] * side / (along * light->tangent),
          y = -p[(k + 2) % 3] / (along * light->tangent);
    if (layer == 0 || layer > map->layers || !inside(x, y))
        return s;
    uint32_t u = texel(x, map->face_size), v = texel(y, map->face_size);
    float depth = fetch(map, layer - 1, u, v);
    if (depth > 0) {
        float a = center(u, map->face_size) * light->tangent, b = center(v, map->face_size) * light->tangent;
        s.occluder = light->depth_range / depth * sqrtf(1 + a * a + b * b);
    }
    return s;
}

static struct lf_shadow_distance look_into_windows(const struct lf_depth_map *map, const float p[3])
{
    const struct ng_light_data *light = map->light;
    uint32_t count = light->window_count < map->layers ? light->window_count : map->layers;
    // The coarsest window begins where the light enters the scene's sphere.
    struct lf_shadow_distance s;
    s.receiver = s.occluder = p[0] - light->windows[light->window_count - 1][3];
    for (uint32_t i = 0; i < count; i++) {
        const float *w = light->windows[i];
        float x = (p[1] - w[0]) / w[2], y = (w[1] - p[2]) / w[2];
        if (!inside(x, y))
            continue;
        float depth = fetch(map, i, texel(x, map->face_size), texel(y, map->face_size));
        s.receiver = s.occluder = p[0] - w[3];
        if (depth > 0)
            s.occluder = (1 - depth) * light->depth_range;
        return s;
    }
    return s;
}

struct lf_shadow_distance lf_shadow_lookup(const struct lf_depth_map *map, const float position[3])
{
    float p[3];
    to_light_frame(map->light, position, p);
    return map->light->window_count ? look_into_windows(map, p) : look_into_cube(map, p);
}
