// Files that know nothing of our lights and cameras (NG_scene): their emissive meshes, which glow in every
// program, also light the scene, and a light meter exposes their pictures, since their lamps are of any
// strength.
#include "asset/gltf_loader_internal.h"
#include "components/camera.h"
#include "components/components.h"
#include "components/light_mesh.h"
#include "components/material.h"
#include "components/mesh.h"

// Emissive meshes that are lights each for itself; of more, those of one material are one light together. A
// light costs views and shadows of its own.
#define MOST_ALONE 16
#define MOST       256 // lights of emissive materials

bool ng_gltf_is_foreign(const struct gltf_document *d)
{
    bool own = false;
    for (uint32_t i = 0; i < d->scene_count; i++)
        own = own || d->scenes[i].extension;
    for (uint32_t i = 0; i < d->node_count; i++)
        own = own || d->nodes[i].extension;
    for (uint32_t i = 0; i < d->material_count; i++)
        own = own || d->materials[i].extension;
    for (uint32_t i = 0; i < d->animation_count; i++)
        own = own || d->animations[i].extension;
    for (uint32_t i = 0; i < d->mesh_count; i++)
        for (uint32_t k = 0; k < d->meshes[i].primitive_count; k++)
            own = own || d->meshes[i].primitives[k].extension;
    return !own;
}

void ng_gltf_expose(const struct gltf_loader *l, struct ng_camera *camera)
{
    const float grey = 0.05f;
    if (!l->out.foreign)
        return;
    camera->auto_exposure = true;
    for (int i = 0; i < 3; i++)
        camera->background[i] = grey;
}

static bool emits(const struct gltf_loader *l, ng_entity e)
{
    const struct ng_mesh *mesh = ng_world_get(l->world, e, NG_MESH);
    const struct ng_material *m = mesh ? ng_world_get(l->world, mesh->material, NG_MATERIAL) : NULL;
    float most = 0;
    for (int i = 0; m && i < 3; i++)
        most = m->emissive[i] > most ? m->emissive[i] : most;
    return m && !m->unlit && most * m->emissive_strength > 0;
}

static bool is_light(const struct gltf_loader *l, ng_entity e)
{
    for (ng_component c = 0; c < NG_COMPONENT_COUNT; c++)
        if (ng_component_is_light(c) && ng_world_has(l->world, e, c))
            return true;
    return false;
}

// Makes an emissive mesh a light, or with all others of its material.
static ng_result light_up(struct gltf_loader *l, ng_entity e, bool merged)
{
    if (!emits(l, e) || is_light(l, e))
        return NG_OK;
    if (merged)
        e = ((const struct ng_mesh *)ng_world_get(l->world, e, NG_MESH))->material;
    if (is_light(l, e))
        return NG_OK;
    if (l->out.emitter_count == MOST) {
        ng_gltf_warn(l, &l->warned_emitters, "more than %d materials emit; the others' light is not followed",
                     MOST);
        return NG_OK;
    }
    l->out.emitter_count++;
    l->out.light_count++;
    return ng_gltf_add(l, e, "an emissive mesh", NG_LIGHT_MESH, ng_light_mesh_component.defaults);
}

ng_result ng_gltf_emitters(struct gltf_loader *l)
{
    enum ng_gltf_emitters wanted = l->limits.emissive_lights;
    if (wanted == NG_GLTF_EMITTERS_OFF || (wanted == NG_GLTF_EMITTERS_AUTO && !l->out.foreign))
        return NG_OK;
    uint32_t count = 0;
    for (size_t i = 0; i < l->instances.count; i++)
        count += emits(l, l->instances.items[i].entity);
    for (size_t i = 0; i < l->instances.count; i++)
        NG_TRY(light_up(l, l->instances.items[i].entity, count > MOST_ALONE));
    return NG_OK;
}
