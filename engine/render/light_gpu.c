// Views are frames of three axes with x * y = z (cross product), picture right, down and forward, like the
// camera's: so that front faces have the same order on screen everywhere.
#include "render/light_gpu.h"

#include "render/light_facets.h"
#include "render/passes.h"

#include <cglm/cglm.h>
#include <string.h>

// Near plane of perspective views, in scene radii, and in metres at most: what hangs closely before a lamp
// shadows.
#define NEAR_SHARE         1e-5f
#define MOST_NEAR          2e-5f
#define CASCADES           4
// A light at infinity is a sky if the tangent of the half angle over which it is spread is larger than this.
#define SKY_SPREAD         0.15f
#define LEAST_SKY_VIEWS    8u
#define MOST_SKY_TRIANGLES 4000000u // in all views together
#define FRAME_FACETS       65536u   // of all lights together
#define SLICE_NEAR         0.05f    // metres: nothing nearer to the camera deserves a cascade of its own

static void copy3(float to[3], const float from[3])
{
    memcpy(to, from, 3 * sizeof(float));
}

static void set_axes(struct ng_light_view_data *v, const float look[3], const float up[3])
{
    vec3 z, x, y;
    glm_vec3_normalize_to((float *)look, z);
    glm_vec3_cross(z, (float *)up, x);
    glm_vec3_normalize(x);
    glm_vec3_cross(z, x, y);
    copy3(v->axis_x, x);
    copy3(v->axis_y, y);
    copy3(v->axis_z, z);
}

// The matrix that rasterizes what the members describe.
static void set_matrix(struct ng_light_view_data *v, bool orthographic)
{
    float *m = v->view_projection;
    float range = v->depth_range;
    for (int c = 0; c < 3; c++) {
        m[c * 4 + 0] = v->axis_x[c] / v->tangent;
        m[c * 4 + 1] = v->axis_y[c] / v->tangent;
        m[c * 4 + 2] = orthographic ? -v->axis_z[c] / range : 0.0f;
        m[c * 4 + 3] = orthographic ? 0.0f : v->axis_z[c];
    }
    m[12] = -glm_vec3_dot(v->axis_x, v->origin) / v->tangent;
    m[13] = -glm_vec3_dot(v->axis_y, v->origin) / v->tangent;
    m[14] = orthographic ? 1.0f + glm_vec3_dot(v->axis_z, v->origin) / range : range;
    m[15] = orthographic ? 1.0f : -glm_vec3_dot(v->axis_z, v->origin);
}

// ---- VPLs ------------------------------------------------------------------------------------------------

static void observe_vpls(const struct ng_light_source *s, struct ng_light_gpu *out)
{
    struct ng_light_sample samples[NG_LIGHT_VPLS];
    bool delta = s->type->delta;
    uint32_t count = delta ? 1 : NG_LIGHT_VPLS, used = 0;
    ng_light_vpls(s, count, samples);
    for (uint32_t i = 0; i < count; i++) {
        if (!(samples[i].pdf > 0))
            continue;
        struct ng_vpl_data *v = &out->vpls[used++];
        copy3(v->position, samples[i].position);
        copy3(v->normal, samples[i].normal);
        v->density = samples[i].pdf * (float)count;
        for (int c = 0; c < 3; c++)
            v->weight[c] = samples[i].radiance[c] / v->density;
    }
    out->data.vpl_count = used;
    out->data.vpl_kind = s->type->infinite ? NG_VPL_DIRECTIONAL : delta ? NG_VPL_POINT : NG_VPL_AREA;
}

static double vpl_weight(const struct ng_vpl_data *v)
{
    return (double)v->weight[0] + (double)v->weight[1] + (double)v->weight[2];
}

// What makes penumbrae: the radius of a disk with the VPLs' second moment, or for lights at infinity the
// tangent of the half angle under which they are spread; and how flat the emitter is.
static void observe_softness(const struct ng_light_proxy *proxy, bool infinite, struct ng_light_gpu *l)
{
    double sum = 0, weights = 0;
    vec3 normal = {0};
    for (uint32_t i = 0; i < l->data.vpl_count; i++) {
        struct ng_vpl_data *v = &l->vpls[i];
        double weight = vpl_weight(v), c = glm_vec3_dot(v->normal, (float *)proxy->direction);
        double square = infinite ? 1.0 - c * c : glm_vec3_distance2(v->position, (float *)proxy->position);
        sum += weight * square;
        weights += weight;
        glm_vec3_muladds(v->normal, (float)weight, normal);
    }
    if (!(weights > 0))
        return;
    struct ng_light_data *d = &l->data;
    float radius = (float)sqrt(2.0 * sum / weights);
    d->soft_radius = infinite ? radius / sqrtf(fmaxf(1.0f - radius * radius, 0.5f)) : radius;
    glm_vec3_scale(normal, (float)(1 / weights), normal);
    d->soft_normal[0] = glm_vec3_dot(normal, d->look);
    d->soft_normal[1] = glm_vec3_dot(normal, d->right);
    d->soft_normal[2] = glm_vec3_dot(normal, d->up);
}

// ---- Views -----------------------------------------------------------------------------------------------

// Whether the light sends anything into a perspective view: intensity is largest at a corner for a flat
// emitter.
static bool emits_into(const struct ng_light_gpu *l, const struct ng_light_view_data *v)
{
    if (l->data.vpl_kind == NG_VPL_POINT)
        return true;
    for (uint32_t i = 0; i < l->data.vpl_count; i++)
        for (int corner = 0; corner < 4; corner++) {
            vec3 d;
            for (int a = 0; a < 3; a++)
                d[a] = v->axis_z[a] + v->axis_x[a] * (corner & 1 ? 1.0f : -1.0f) +
                       v->axis_y[a] * (corner & 2 ? 1.0f : -1.0f);
            if (glm_vec3_dot((float *)l->vpls[i].normal, d) > 1e-4f)
                return true;
        }
    return false;
}

// The faces of ng_light_data's cube into which the light sends something.
static uint32_t cube_views(struct ng_light_gpu *l, float near_plane)
{
    struct ng_light_data *d = &l->data;
    const float *axes[3] = {d->look, d->right, d->up};
    uint32_t count = 0;
    for (uint32_t face = 0; face < 6; face++) {
        vec3 look;
        glm_vec3_scale((float *)axes[face % 3], face < 3 ? 1.0f : -1.0f, look);
        struct ng_light_view_data *v = &l->rsm_views[count];
        *v = (struct ng_light_view_data){.tangent = 1.0f, .depth_range = near_plane};
        copy3(v->origin, d->proxy);
        set_axes(v, look, axes[(face + 2) % 3]);
        set_matrix(v, false);
        if (emits_into(l, v))
            d->layers |= ++count << (4 * face);
    }
    return count;
}

static void orthographic_view(const struct ng_snapshot *s, const struct ng_light_proxy *p,
                              const float center[3], float half_width, struct ng_light_view_data *v)
{
    *v = (struct ng_light_view_data){.tangent = half_width, .depth_range = 2 * s->scene_radius};
    set_axes(v, p->direction, p->up);
    // The near plane touches the scene's sphere where light enters it.
    vec3 offset;
    glm_vec3_sub((float *)center, (float *)s->scene_center, offset);
    float back = glm_vec3_dot(offset, v->axis_z) + s->scene_radius;
    for (int a = 0; a < 3; a++)
        v->origin[a] = center[a] - v->axis_z[a] * back;
    set_matrix(v, true);
}

// Where slice `i` of the camera's view begins, metres: between even in the logarithm, which gives all slices
// the same resolution on screen, and quadratic, which spares the nearest centimetres (Zhang et al. 2006).
static float slice_begin(int i, float near_plane, float far)
{
    float t = (float)i / CASCADES;
    return i ? glm_lerp(near_plane * powf(far / near_plane, t), far * t * t, 0.1f) : 0.0f;
}

// The sphere around a slice: its centre's distance and its radius, metres.
static void cascade_of_perspective(const struct ng_snapshot_camera *c, float far, float aspect, int i,
                                   float *middle, float *radius)
{
    float near_plane = fmaxf(c->near_plane, SLICE_NEAR), tangent = tanf(c->fov_y * 0.5f);
    float corner = tangent * sqrtf(1 + aspect * aspect);
    float begin = slice_begin(i, near_plane, far), end = slice_begin(i + 1, near_plane, far);
    *middle = fminf(0.5f * (begin + end) * (1 + corner * corner), end);
    *radius = sqrtf((end - *middle) * (end - *middle) + end * end * corner * corner);
}

// Parallel rays see all depths at one size: slices are equal.
static void cascade_of_parallel(const struct ng_snapshot *s, float aspect, int i, float *middle,
                                float *radius)
{
    const struct ng_snapshot_camera *c = &s->camera;
    float center = -c->view[14], corner = 0.5f * c->height * sqrtf(1 + aspect * aspect);
    for (int k = 0; k < 3; k++)
        center -= c->view[k * 4 + 2] * s->scene_center[k];
    float begin = fmaxf(center - s->scene_radius, 0),
          half = fmaxf(center + s->scene_radius - begin, 0) / (2 * CASCADES);
    *middle = begin + (float)(2 * i + 1) * half;
    *radius = sqrtf(half * half + corner * corner);
}

// Slices of the camera's frustum, each in a bounding sphere, so that turning the camera does not resize the
// maps.
static void cascade_views(const struct ng_snapshot *s, const struct ng_light_proxy *p, float aspect,
                          struct ng_light_view_data *views)
{
    const struct ng_snapshot_camera *c = &s->camera;
    for (int i = 0; i < CASCADES; i++) {
        float middle, radius;
        vec3 center;
        if (c->orthographic)
            cascade_of_parallel(s, aspect, i, &middle, &radius);
        else
            cascade_of_perspective(c, 2 * s->scene_radius, aspect, i, &middle, &radius);
        for (int k = 0; k < 3; k++)
            center[k] = c->position[k] - c->view[k * 4 + 2] * middle;
        orthographic_view(s, p, center, radius, &views[i]);
    }
}

static void observe_views(const struct ng_snapshot *s, const struct ng_light_proxy *p, float aspect,
                          float cascade_radius, struct ng_light_gpu *l)
{
    struct ng_light_view_data *first = &l->rsm_views[0];
    struct ng_light_data *d = &l->data;
    d->depth_range = fminf(NEAR_SHARE * s->scene_radius, MOST_NEAR);
    d->tangent = 1;
    l->rsm_view_count = 1;
    switch (p->views) {
    case NG_VIEWS_CUBE:
        l->rsm_view_count = cube_views(l, d->depth_range);
        break;
    case NG_VIEWS_SINGLE_PERSPECTIVE:
        d->tangent = tanf(p->fov * 0.5f);
        d->layers = 1;
        *first = (struct ng_light_view_data){.tangent = d->tangent, .depth_range = d->depth_range};
        copy3(first->origin, p->position);
        set_axes(first, p->direction, p->up);
        set_matrix(first, false);
        break;
    case NG_VIEWS_SINGLE_ORTHOGRAPHIC:
        d->depth_range = 2 * s->scene_radius;
        d->window_count = 1;
        orthographic_view(s, p, s->scene_center, p->extent, first);
        if (s->scene_radius > cascade_radius) {
            d->window_count = l->depth_view_count = CASCADES;
            cascade_views(s, p, aspect, l->depth_views);
            return;
        }
        break;
    }
    memcpy(l->depth_views, l->rsm_views, sizeof l->rsm_views);
    l->depth_view_count = l->rsm_view_count;
}

// All VPLs have one, unless the scene has so many triangles that a frame in which something moves would take
// long.
static uint32_t count_sky_views(const struct ng_snapshot *s, uint32_t vpls)
{
    uint64_t triangles = 0;
    for (uint32_t i = 0; i < s->instance_count; i++)
        triangles += s->meshes[s->instances[i].mesh].index_count / 3;
    uint32_t count = vpls;
    while (count > LEAST_SKY_VIEWS && triangles * count > MOST_SKY_TRIANGLES)
        count /= 2;
    return count;
}

void ng_light_gpu_observe(const struct ng_snapshot *snapshot, uint32_t light,
                          const struct ng_light_source *source, float aspect, float cascade_radius,
                          struct ng_light_gpu *out)
{
    struct ng_light_data *d = &out->data;
    struct ng_light_source unit;
    struct ng_light_proxy proxy;
    *out = (struct ng_light_gpu){0};
    observe_vpls(source, out);
    ng_light_unit(source, &unit); // where the proxy is follows from radiances, but not to the last bit
    ng_light_proxy_of(&unit, &proxy);
    if (source->type->surface) // past other lamps in its place
        glm_vec3_muladds(proxy.direction, snapshot->place_size, proxy.position);
    copy3(d->proxy, proxy.position);
    copy3(d->look, proxy.direction);
    copy3(d->up, proxy.up);
    glm_vec3_cross(d->look, d->up, d->right);
    ng_light_cone(source, &d->cone_scale, &d->cone_offset);
    observe_softness(&proxy, source->type->infinite, out);
    if (source->type->infinite && d->soft_radius > SKY_SPREAD)
        out->sky_view_count = count_sky_views(snapshot, d->vpl_count);
    d->vpl_radius = d->vpl_count ? d->soft_radius / sqrtf((float)d->vpl_count) : 0;
    d->index = light;
    observe_views(snapshot, &proxy, aspect, cascade_radius, out);
}

static void snap_to_texels(struct ng_light_view_data *v, float texel)
{
    const float *axes[2] = {v->axis_x, v->axis_y};
    for (int a = 0; a < 2; a++) {
        float at = glm_vec3_dot((float *)axes[a], v->origin);
        glm_vec3_muladds((float *)axes[a], floorf(at / texel) * texel - at, v->origin);
    }
    set_matrix(v, true);
}

void ng_light_gpu_set_face_size(struct ng_light_gpu *l, uint32_t face_size)
{
    struct ng_light_data *d = &l->data;
    d->face_size = (float)face_size;
    for (uint32_t i = 0; i < d->window_count; i++) {
        struct ng_light_view_data *v = &l->depth_views[i];
        if (d->window_count > 1) // cascades follow the camera, but never by a part of a texel
            snap_to_texels(v, 2 * v->tangent / d->face_size);
        vec3 offset;
        glm_vec3_sub(v->origin, d->proxy, offset);
        d->windows[i][0] = glm_vec3_dot(offset, d->right);
        d->windows[i][1] = glm_vec3_dot(offset, d->up);
        d->windows[i][2] = v->tangent;
        d->windows[i][3] = glm_vec3_dot(offset, d->look);
    }
}

void ng_light_gpu_sky_view(const struct ng_light_gpu *l, const struct ng_snapshot *s, uint32_t vpl,
                           struct ng_light_view_data *out)
{
    struct ng_light_proxy p;
    copy3(p.direction, l->vpls[vpl].normal);
    const float up[3] = {0, fabsf(p.direction[1]) < 0.9f, fabsf(p.direction[1]) >= 0.9f};
    copy3(p.up, up);
    orthographic_view(s, &p, s->scene_center, s->scene_radius, out);
}

// ---- Buffers ---------------------------------------------------------------------------------------------

static ng_result record_facets(struct ng_gpu *gpu, const struct ng_snapshot *snapshot, struct ng_light_gpu *l)
{
    struct ng_light_facets f;
    ng_light_facets_of(&snapshot->lights[l->data.index].source, FRAME_FACETS / snapshot->light_count, &f);
    l->data.facet_kind = f.kind;
    l->data.facet_count = f.count;
    return ng_frame_put(gpu, f.facets, (f.count ? f.count : 1) * sizeof f.facets[0], &l->facet_range);
}

ng_result ng_light_gpu_record(struct ng_gpu *gpu, const struct ng_snapshot *snapshot, struct ng_light_gpu *l)
{
    if (l->sky_view_count) {
        NG_TRY(ng_frame_alloc(gpu, l->sky_view_count * sizeof(struct ng_light_view_data), &l->sky_range));
        struct ng_light_view_data *views = l->sky_range.mapped;
        for (uint32_t i = 0; i < l->sky_view_count; i++)
            ng_light_gpu_sky_view(l, snapshot, i, &views[i]);
    }
    NG_TRY(record_facets(gpu, snapshot, l));
    NG_TRY(ng_frame_put(gpu, &l->data, sizeof l->data, &l->data_range));
    NG_TRY(ng_frame_put(gpu, l->vpls, sizeof l->vpls, &l->vpl_range));
    NG_TRY(ng_frame_put(gpu, l->depth_views, sizeof l->depth_views, &l->depth_view_range));
    return ng_frame_put(gpu, l->rsm_views, sizeof l->rsm_views, &l->rsm_view_range);
}

void ng_light_gpu_bindings(const struct ng_light_gpu *l, bool rsm, struct ng_gpu_binding out[3])
{
    const struct ng_frame_range *ranges[3] = {rsm ? &l->rsm_view_range : &l->depth_view_range, &l->data_range,
                                              &l->vpl_range};
    for (uint32_t i = 0; i < 3; i++)
        out[i] = ng_pass_range(ranges[i], 7 + i);
}
