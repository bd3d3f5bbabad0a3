// Materials become entities.
#include "asset/gltf_loader_internal.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"
#include "components/components.h"
#include "components/material.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void ng_gltf_numbers(const struct gltf_value *object, const char *key, uint32_t count, float *out)
{
    const struct gltf_value *v = ng_gltf_array(object, key);
    for (uint32_t i = 0; v && v->count == count && i < count; i++)
        if (v->items[i].kind == GLTF_NUMBER)
            out[i] = (float)v->items[i].number;
}

ng_result ng_gltf_use_texture(struct gltf_loader *l, const char *where, const struct gltf_texture_use *use,
                              bool srgb, const struct gltf_slot *slot)
{
    const struct gltf_value *moved = ng_gltf_member(use->extensions, "KHR_texture_transform");
    if (use->texture == -1)
        return NG_OK;
    int uv_set = ng_gltf_index(moved, "texCoord", use->uv_set);
    if (uv_set < 0 || uv_set > 1)
        ng_gltf_warn(l, &l->warned_uv, "%s: a texture uses TEXCOORD_%d; TEXCOORD_0 is used instead", where,
                     uv_set);
    *slot->uv_set = uv_set == 1;
    ng_gltf_numbers(moved, "offset", 2, slot->transform->offset);
    ng_gltf_numbers(moved, "scale", 2, slot->transform->scale);
    slot->transform->rotation = (float)ng_gltf_number(moved, "rotation", 0);
    struct gltf_part part;
    ng_gltf_part_begin(&part, "the scene is drawn without it");
    part.where = where;
    return ng_gltf_part_end(&l->faults, &part, ng_gltf_texture(l, where, use->texture, srgb, slot->image));
}

static void copy3(float out[3], const double *in)
{
    for (int i = 0; i < 3; i++)
        out[i] = (float)in[i];
}

static ng_result alpha_mode(struct gltf_loader *l, const char *where, const char *mode, uint32_t *out)
{
    static const char *const modes[] = {
        [NG_ALPHA_OPAQUE] = "OPAQUE", [NG_ALPHA_MASK] = "MASK", [NG_ALPHA_BLEND] = "BLEND"};
    for (*out = 0; *out < NG_COUNT(modes); ++*out)
        if (strcmp(mode, modes[*out]) == 0)
            return NG_OK;
    *out = NG_ALPHA_OPAQUE;
    return ng_gltf_fault(&l->faults, "OPAQUE is used", "%s: alphaMode \"%.40s\" is not OPAQUE, MASK or BLEND",
                         where, mode);
}

// KHR_materials_ior and KHR_materials_specular.
static ng_result dielectric(struct gltf_loader *l, const char *where, const struct gltf_material *m,
                            struct ng_material *out)
{
    const struct gltf_value *specular = ng_gltf_member(m->extensions, "KHR_materials_specular");
    const struct gltf_value *ior = ng_gltf_member(m->extensions, "KHR_materials_ior");
    const struct gltf_texture_use weight = ng_gltf_texture_use(specular, "specularTexture");
    const struct gltf_texture_use color = ng_gltf_texture_use(specular, "specularColorTexture");
    out->ior = (float)ng_gltf_number(ior, "ior", 1.5);
    out->specular = (float)ng_gltf_number(specular, "specularFactor", 1);
    ng_gltf_numbers(specular, "specularColorFactor", 3, out->specular_color);
    NG_TRY(ng_gltf_use_texture(l, where, &weight, false, GLTF_SLOT(out, specular)));
    return ng_gltf_use_texture(l, where, &color, true, GLTF_SLOT(out, specular_color));
}

// Before KHR_materials_emissive_strength exporters wrote factors above 1.
static ng_result emission(struct gltf_loader *l, const char *where, const struct gltf_material *m,
                          struct ng_material *out)
{
    copy3(out->emissive, m->emissive.items);
    out->emissive_strength = (float)m->emissive_strength;
    float most = fmaxf(fmaxf(out->emissive[0], out->emissive[1]), out->emissive[2]);
    if (!(most > 1) || !isfinite(most))
        return NG_OK;
    for (int i = 0; i < 3; i++)
        out->emissive[i] /= most;
    out->emissive_strength *= most;
    return ng_gltf_fault(&l->faults, "it counts as strength", "%s: emissiveFactor has %g, more than 1", where,
                         (double)most);
}

static ng_result make_material(struct gltf_loader *l, const char *where, const struct gltf_material *m,
                               ng_entity e)
{
    const struct gltf_value *glossiness =
        ng_gltf_member(m->extensions, "KHR_materials_pbrSpecularGlossiness");
    struct ng_material out;
    memcpy(&out, ng_material_component.defaults, sizeof out);
    copy3(out.base_color, m->base_color.items);
    NG_TRY(emission(l, where, m, &out));
    out.alpha = (float)m->base_color.items[3];
    out.metallic = (float)m->metallic;
    out.roughness = (float)m->roughness;
    out.alpha_cutoff = (float)m->alpha_cutoff;
    out.normal_scale = (float)m->normal_scale;
    out.double_sided = m->double_sided;
    const struct gltf_value *unlit = ng_gltf_member(m->extensions, "KHR_materials_unlit");
    out.unlit = unlit && unlit->kind == GLTF_OBJECT;
    NG_TRY(alpha_mode(l, where, m->alpha_mode, &out.alpha_mode));
    if (m->occlusion)
        ng_gltf_warn(l, &l->warned_occlusion,
                     "%s: its occlusionTexture is not followed, since light is computed", where);
    NG_TRY(ng_gltf_use_texture(l, where, &m->normal_texture, false, GLTF_SLOT(&out, normal)));
    NG_TRY(ng_gltf_use_texture(l, where, &m->emissive_texture, true, GLTF_SLOT(&out, emissive)));
    if (glossiness && !out.unlit) {
        NG_TRY(ng_gltf_glossiness(l, where, glossiness, &out));
    } else {
        NG_TRY(ng_gltf_use_texture(l, where, &m->base_color_texture, true, GLTF_SLOT(&out, base_color)));
        NG_TRY(ng_gltf_use_texture(l, where, &m->metallic_roughness_texture, false,
                                   GLTF_SLOT(&out, metallic_roughness)));
        NG_TRY(dielectric(l, where, m, &out));
    }
    NG_TRY(ng_gltf_add(l, e, where, NG_MATERIAL, &out));
    return ng_gltf_components(l, e, where, m->extension, NULL);
}

ng_result ng_gltf_materials(struct gltf_loader *l)
{
    const struct gltf_document *d = l->doc;
    if (d->material_count == 0)
        return NG_OK;
    ng_entity group;
    NG_TRY(ng_gltf_entity(l, l->out.root, "materials", "group", 0, &group));
    for (uint32_t i = 0; i < d->material_count; i++) {
        const struct gltf_material *m = &d->materials[i];
        char where[32];
        snprintf(where, sizeof where, "material %u", i);
        NG_TRY(ng_gltf_entity(l, group, m->name, "material", i, &l->materials[i]));
        NG_TRY(make_material(l, where, m, l->materials[i]));
    }
    l->out.material_count = d->material_count;
    return NG_OK;
}
