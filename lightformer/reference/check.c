// A light that is dark because it is off or black is as its author wants it; one that is dark although its
// numbers say that it shines is a mistake, and so is what would silently be left out of every picture.
#include "lightformer/reference/check.h"

#include "base/log.h"
#include "components/components.h"
#include "components/name.h"
#include "lightformer/trace/vec.h"
#include "render/snapshot.h"
#include "scene/world.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

struct check {
    const char *scene;
    enum lf_check_faults faults;
};

static ng_result fault(const struct check *c, const char *fmt, ...) NG_PRINTF(2, 3);
static ng_result fault(const struct check *c, const char *fmt, ...)
{
    char text[512];
    va_list args;
    va_start(args, fmt);
    vsnprintf(text, sizeof text, fmt, args);
    va_end(args);
    if (c->faults == LF_CHECK_REFUSE)
        ng_log_error("%s", text);
    else if (c->faults == LF_CHECK_WARN)
        ng_log_warn("%s", text);
    return c->faults == LF_CHECK_REFUSE ? NG_ERROR_FORMAT : NG_OK;
}

// ---- triangles -------------------------------------------------------------------------------------------

// Twice the area. Differences of floats are exact in double precision, so that what is exactly flat gives 0.
static double doubled_area(const float *a, const float *b, const float *c)
{
    double u[3], v[3], square = 0;
    for (int i = 0; i < 3; i++) {
        u[i] = (double)b[i] - (double)a[i];
        v[i] = (double)c[i] - (double)a[i];
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        double n = u[j] * v[k] - u[k] * v[j];
        square += n * n;
    }
    return sqrt(square);
}

static bool has_area(const struct ng_snapshot_mesh *mesh)
{
    for (uint32_t t = 0; t < mesh->index_count; t += 3) {
        const uint32_t *i = mesh->indices + t;
        const float *p = mesh->positions;
        if (doubled_area(p + i[0] * (size_t)3, p + i[1] * (size_t)3, p + i[2] * (size_t)3) > 0)
            return true;
    }
    return false;
}

// An instance that a file's mesh has; null for the shapes of lights, of which more is said as lights.
static const struct ng_snapshot_instance *find_user(const struct ng_snapshot *s, uint32_t mesh)
{
    for (uint32_t i = 0; i < s->instance_count; i++)
        if (s->instances[i].mesh == mesh && s->instances[i].light == NG_NONE)
            return &s->instances[i];
    return NULL;
}

static ng_result check_meshes(const struct check *c, const struct ng_world *world,
                              const struct ng_snapshot *s)
{
    for (uint32_t m = 0; m < s->mesh_count; m++) {
        const struct ng_snapshot_mesh *mesh = &s->meshes[m];
        const struct ng_snapshot_instance *user = has_area(mesh) ? NULL : find_user(s, m);
        if (mesh->dynamic || !user)
            continue;
        const struct ng_name *name = ng_world_get(world, user->entity, NG_NAME);
        NG_TRY(
            fault(c,
                  "%s: mesh \"%s\": its triangles (%u) are degenerate: none has an area to be seen; repair "
                  "the mesh, or remove it",
                  c->scene, name ? name->text : "", mesh->index_count / 3));
    }
    return NG_OK;
}

// ---- lights ----------------------------------------------------------------------------------------------

static double area_of(const struct ng_light_source *source, const struct ng_light_surface *surface)
{
    const float origin[3] = {0}, *x = surface->matrix, *y = surface->matrix + 4;
    double area = 0;
    if (surface->shape != NG_LIGHT_SHAPE_MESH)
        return doubled_area(origin, x, y); // of two axes of the shape
    for (uint32_t t = 0; t < source->triangle_count; t++) {
        const float *p = source->triangles + (size_t)t * 9;
        area += doubled_area(p, p + 3, p + 6);
    }
    return area;
}

// What is wrong with a light that gives none, and what to do; null if it is meant to be dark.
static const char *mistake(const struct ng_light_source *source)
{
    struct ng_light_surface surface = {0};
    float power[3] = {0};
    if (source->type->surface)
        source->type->surface(source, &surface);
    if (ng_light_mean(surface.radiance) > 0 && !(area_of(source, &surface) > 0))
        return "has no area; give it a size, or switch it off";
    if (source->type->power(source, power) && !isfinite(ng_light_mean(power)))
        return "has a power beyond all numbers; lower its strength, or repair its picture";
    return NULL;
}

static ng_result check_lights(const struct check *c, const struct ng_snapshot *s)
{
    bool light = false;
    for (uint32_t i = 0; i < s->light_count; i++) {
        const struct ng_snapshot_light *l = &s->lights[i];
        const char *wrong = l->power > 0 ? NULL : mistake(&l->source);
        if (wrong)
            NG_TRY(fault(c, "%s: light \"%s\" %s", c->scene, l->name, wrong));
        light |= l->power > 0;
    }
    for (uint32_t i = 0; i < s->material_count; i++)
        light |= lf_max3(s->materials[i].emission) > 0;
    if (light)
        return NG_OK;
    ng_log_error("%s: nothing gives light, so all would be black; add a light, or switch one on", c->scene);
    return NG_ERROR_FORMAT;
}

ng_result lf_check_scene(const struct ng_world *world, const struct ng_snapshot *snapshot, const char *scene,
                         enum lf_check_faults faults)
{
    const struct check c = {scene, faults};
    NG_TRY(check_lights(&c, snapshot));
    return check_meshes(&c, world, snapshot);
}
