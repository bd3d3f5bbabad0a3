// MTL into glTF's metallic-roughness.
//
// Ns, the exponent of a Blinn-Phong lobe, becomes the GGX lobe of equal width: alpha^2 = 2 / (Ns + 2) (Walter
// et al. 2007, section 5.2), so roughness = (2 / (Ns + 2))^(1/4). Colours are sRGB, as programs that show
// such files take them.
#include "asset/image.h"
#include "asset/obj_internal.h"
#include "base/log.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static float unit(float v)
{
    return v > 0 ? fminf(v, 1) : 0; // not a number: 0
}

static float to_linear(float v)
{
    v = unit(v);
    return v <= 0.04045f ? v / 12.92f : powf((v + 0.055f) / 1.055f, 2.4f);
}

static float largest(const float c[3])
{
    return fmaxf(unit(c[0]), fmaxf(unit(c[1]), unit(c[2])));
}

// ---- pictures --------------------------------------------------------------------------------------------
static bool png_has_alpha(const unsigned char *data, size_t size)
{
    if (size < 33 || memcmp(data, "\x89PNG", 4) != 0)
        return false;
    if (data[25] == 4 || data[25] == 6)
        return true;
    for (size_t at = 8; at + 12 <= size;) { // chunks up to the first of the pixels
        size_t length =
            (size_t)data[at] << 24 | (size_t)data[at + 1] << 16 | (size_t)data[at + 2] << 8 | data[at + 3];
        if (memcmp(data + at + 4, "tRNS", 4) == 0)
            return true;
        if (memcmp(data + at + 4, "IDAT", 4) == 0 || length > size - at - 12)
            return false;
        at += length + 12;
    }
    return false;
}

// Without quotes, folders as Unix writes them. Of an absolute path, which is of another machine, the file's
// name.
static void clean_name(const char *name, char *out, size_t size)
{
    size_t n = 0, length = strlen(name);
    bool quoted = length >= 2 && (*name == '"' || *name == '\'') && name[length - 1] == *name;
    for (size_t i = quoted; i < length - quoted && n + 1 < size; i++)
        out[n++] = name[i] == '\\' ? '/' : name[i];
    out[n] = 0;
    bool absolute = out[0] == '/' || (out[0] && out[1] == ':');
    const char *base = absolute ? strrchr(out, '/') : NULL;
    if (base)
        memmove(out, base + 1, strlen(base));
    while (strncmp(out, "./", 2) == 0)
        memmove(out, out + 2, strlen(out + 2) + 1);
}

static ng_result read_named(struct obj_model *m, const char *name, const char *instead, void **data,
                            size_t *size)
{
    struct gltf_part part;
    char file[1024];
    clean_name(name, file, sizeof file);
    *data = NULL;
    ng_gltf_part_begin(&part, instead);
    return ng_gltf_part_end(m->faults, &part, m->source->read(m->source->user, file, data, size));
}

// Null where it cannot be read. `bump`: heights become normals.
static ng_result read_picture(struct obj_model *m, const char *name, bool bump, void **data, size_t *size)
{
    struct gltf_part part;
    NG_TRY(read_named(m, name, "it is drawn without", data, size));
    if (!*data || !bump)
        return NG_OK;
    ng_gltf_part_begin(&part, "it is drawn without");
    ng_result r = ng_obj_normal_map(m->faults->path, m->params, data, size);
    if (r != NG_OK) {
        free(*data);
        *data = NULL;
    }
    return ng_gltf_part_end(m->faults, &part, r);
}

// Sets `*image` to the index of the picture in the list; -1: it cannot be read.
static ng_result find_image(struct obj_model *m, const char *name, bool bump, int *image, bool *has_alpha)
{
    char key[1024];
    snprintf(key, sizeof key, "%s%s", bump ? "bump " : "", name);
    uint32_t index = ng_obj_name(&m->textures, key);
    if (index == UINT32_MAX)
        return ng_out_of_memory(m->faults->path);
    if (index == m->images.count) {
        void *data;
        size_t size;
        int found = -1;
        NG_TRY(read_picture(m, name, bump, &data, &size));
        bool alpha = data && png_has_alpha(data, size);
        if (data) {
            uint32_t view = ng_obj_view(&m->glb, data, size);
            found = (int)ng_obj_begin(&m->glb, OBJ_IMAGES);
            ng_obj_item(&m->glb, OBJ_IMAGES, "{\"bufferView\":%u,\"mimeType\":\"image/%s\",\"name\":", view,
                        size > 1 && *(unsigned char *)data == 0xff ? "jpeg" : "png");
            ng_obj_item_string(&m->glb, OBJ_IMAGES, name);
            ng_obj_item(&m->glb, OBJ_IMAGES, "}");
        }
        free(data);
        if (!ng_array_push(&m->images, found) || !ng_array_push(&m->alphas, alpha))
            return ng_out_of_memory(m->faults->path);
    }
    *image = m->images.items[index];
    *has_alpha = m->alphas.items[index];
    return NG_OK;
}

// A texture of a map's picture; -1 if there is none.
static ng_result make_texture(struct obj_model *m, const struct obj_map *map, bool bump, int *texture,
                              bool *has_alpha)
{
    int image = -1;
    *texture = -1;
    *has_alpha = false;
    if (map->name[0])
        NG_TRY(find_image(m, map->name, bump, &image, has_alpha));
    if (image < 0)
        return NG_OK;
    if (map->clamp && m->glb.lists[OBJ_SAMPLERS].count == 0) {
        ng_obj_begin(&m->glb, OBJ_SAMPLERS);
        ng_obj_item(&m->glb, OBJ_SAMPLERS, "{\"wrapS\":33071,\"wrapT\":33071}");
    }
    *texture = (int)ng_obj_begin(&m->glb, OBJ_TEXTURES);
    ng_obj_item(&m->glb, OBJ_TEXTURES, "{\"source\":%d%s}", image, map->clamp ? ",\"sampler\":0" : "");
    return NG_OK;
}

// ---- materials -------------------------------------------------------------------------------------------
struct look {
    float base[3], alpha, metallic, roughness, specular;
    int base_texture, normal_texture, emission_texture;
    bool mask;
};

// Models 3, 5 and 8 reflect what is around: with little colour of its own such a thing is a metal.
static bool is_mirror(const struct obj_material *in)
{
    bool reflects = in->illum == 3 || in->illum == 5 || in->illum == 8;
    return reflects && largest(in->specular) > 0.4f && largest(in->specular) > 2 * largest(in->diffuse);
}

static void read_look(const struct obj_material *in, struct look *out)
{
    float exponent = in->shininess > 0 && isfinite(in->shininess) ? in->shininess : 0;
    bool shines = in->illum != 0 && in->illum != 1 && largest(in->specular) > 0;
    bool mirror = is_mirror(in);
    for (int i = 0; i < 3; i++)
        out->base[i] = to_linear(mirror ? in->specular[i] : in->diffuse[i]);
    out->alpha = isfinite(in->dissolve) ? unit(in->dissolve) : 1;
    out->metallic = mirror ? 1 : unit(in->metallic);
    out->roughness = in->roughness > 0 ? unit(in->roughness) : shines ? sqrtf(sqrtf(2 / (exponent + 2))) : 1;
    // Ks of 0.5 is the usual reflectance of 0.04.
    out->specular = in->roughness > 0 || in->metallic > 0 ? 1 : shines ? unit(2 * largest(in->specular)) : 0;
}

static ng_result read_textures(struct obj_model *m, const struct obj_material *in, struct look *out)
{
    bool alpha, unused;
    NG_TRY(make_texture(m, &in->diffuse_map, false, &out->base_texture, &alpha));
    bool bump = !in->normal_map.name[0];
    NG_TRY(make_texture(m, bump ? &in->bump_map : &in->normal_map, bump, &out->normal_texture, &unused));
    NG_TRY(make_texture(m, &in->emission_map, false, &out->emission_texture, &unused));
    // Sweet Home 3D shows a picture as it is.
    if (m->source->fit && out->base_texture >= 0)
        out->base[0] = out->base[1] = out->base[2] = 1;
    out->mask = alpha && out->alpha == 1;
    if (in->alpha_map.name[0] && strcmp(in->alpha_map.name, in->diffuse_map.name) != 0)
        NG_TRY(ng_gltf_fault(m->faults, "it is not followed",
                             "material \"%.60s\": map_d is another picture than map_Kd", in->name));
    if (in->unfollowed)
        NG_TRY(ng_gltf_fault(m->faults, "it is not followed", "material \"%.60s\": has %s", in->name,
                             in->unfollowed));
    return NG_OK;
}

static void write_texture(struct obj_glb *g, const char *name, int texture, const char *more)
{
    if (texture >= 0)
        ng_obj_item(g, OBJ_MATERIALS, ",\"%s\":{\"index\":%d%s}", name, texture, more);
}

static void write_emission(struct obj_glb *g, const struct obj_material *in, const struct look *look)
{
    float peak = 0;
    for (int i = 0; i < 3; i++)
        peak = in->emission[i] > peak && isfinite(in->emission[i]) ? in->emission[i] : peak;
    float strength = peak > 1 ? peak : 1;
    bool textured = look->emission_texture >= 0 && peak == 0;
    if (peak > 0 || textured)
        ng_obj_item(g, OBJ_MATERIALS, ",\"emissiveFactor\":[%.9g,%.9g,%.9g]",
                    textured ? 1.0 : (double)unit(in->emission[0] / strength),
                    textured ? 1.0 : (double)unit(in->emission[1] / strength),
                    textured ? 1.0 : (double)unit(in->emission[2] / strength));
    write_texture(g, "emissiveTexture", look->emission_texture, "");
    ng_obj_item(g, OBJ_MATERIALS, ",\"extensions\":{\"KHR_materials_specular\":{\"specularFactor\":%.9g}",
                (double)look->specular);
    g->uses_specular = true;
    g->uses_strength = g->uses_strength || strength > 1;
    if (strength > 1)
        ng_obj_item(g, OBJ_MATERIALS, ",\"KHR_materials_emissive_strength\":{\"emissiveStrength\":%.9g}",
                    (double)strength);
    ng_obj_item(g, OBJ_MATERIALS, "}");
}

// The format knows no back sides.
static void write_material(struct obj_glb *g, const struct obj_material *in, const struct look *look)
{
    char scale[64];
    const struct obj_map *bump = in->normal_map.name[0] ? &in->normal_map : &in->bump_map;
    ng_obj_item(g, OBJ_MATERIALS, "{\"name\":");
    ng_obj_item_string(g, OBJ_MATERIALS, in->name);
    ng_obj_item(
        g, OBJ_MATERIALS,
        ",\"doubleSided\":true,\"alphaMode\":\"%s\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[%.9g,"
        "%.9g,%.9g,%.9g],\"metallicFactor\":%.9g,\"roughnessFactor\":%.9g",
        look->alpha < 1 ? "BLEND"
        : look->mask    ? "MASK"
                        : "OPAQUE",
        (double)look->base[0], (double)look->base[1], (double)look->base[2], (double)look->alpha,
        (double)look->metallic, (double)look->roughness);
    write_texture(g, "baseColorTexture", look->base_texture, "");
    ng_obj_item(g, OBJ_MATERIALS, "}");
    snprintf(scale, sizeof scale, ",\"scale\":%.9g", isfinite(bump->bump) ? (double)bump->bump : 1.0);
    write_texture(g, "normalTexture", look->normal_texture, scale);
    write_emission(g, in, look);
    ng_obj_item(g, OBJ_MATERIALS, "}");
}

// What each material of a library goes through; the first of a name counts, and only what faces use.
static void add_material(void *user, const struct obj_material *in)
{
    struct obj_model *m = user;
    size_t used = m->materials.count; // names that no face has come after
    uint32_t index =
        m->result == NG_OK && in->name[0] ? ng_obj_name(&m->material_names, in->name) : UINT32_MAX;
    if (index >= used || m->materials.items[index].gltf >= 0)
        return;
    struct look look = {0};
    read_look(in, &look);
    m->result = read_textures(m, in, &look);
    if (m->result != NG_OK)
        return;
    m->materials.items[index].gltf = (int)ng_obj_begin(&m->glb, OBJ_MATERIALS);
    m->materials.items[index].diffuse_map = in->diffuse_map;
    m->materials.items[index].diffuse_map.name = NULL;
    write_material(&m->glb, in, &look);
}

static ng_result read_library(struct obj_model *m, const char *name)
{
    void *data;
    size_t size;
    NG_TRY(read_named(m, name, "its materials are plain", &data, &size));
    m->has_library = m->has_library || data;
    ng_result r = data ? ng_obj_materials(m->faults->path, data, size, add_material, m) : NG_OK;
    free(data);
    return r == NG_OK ? m->result : r;
}

static bool is_ending(const char *text)
{
    static const char lower[] = ".mtl", upper[] = ".MTL";
    for (int i = 0; i < 4; i++)
        if (text[i] != lower[i] && text[i] != upper[i])
            return false;
    return true;
}

// Where the first of several names ends: behind ".mtl" and before a blank.
static size_t name_length(const char *names)
{
    for (size_t i = 0; names[i]; i++) {
        size_t end = i + 4;
        if (!is_ending(names + i))
            continue;
        end += names[0] == '"' && names[end] == '"';
        if (names[end] == ' ' || names[end] == '\t')
            return end;
    }
    return strlen(names);
}

// A line may name several files; a file's name may have blanks, and stand in quotes.
static ng_result read_libraries(struct obj_model *m, const char *names)
{
    char name[1024];
    while (*names) {
        size_t length = name_length(names);
        snprintf(name, sizeof name, "%.*s", (int)length, names);
        NG_TRY(read_library(m, name));
        names += length;
        names += strspn(names, " \t");
    }
    return NG_OK;
}

static ng_result note_missing(struct obj_model *m)
{
    for (size_t i = 0; i < m->materials.count && m->has_library; i++)
        if (m->materials.items[i].gltf < 0)
            NG_TRY(ng_gltf_fault(m->faults, "it is plain",
                                 "material \"%.60s\" is in no MTL file that was read",
                                 m->material_names.items.items[i]));
    return NG_OK;
}

ng_result ng_obj_write_materials(struct obj_model *m)
{
    if (!ng_array_resize(&m->materials, m->material_names.items.count))
        return ng_out_of_memory(m->faults->path);
    for (size_t i = 0; i < m->materials.count; i++)
        m->materials.items[i].gltf = -1;
    for (size_t i = 0; i < m->libraries.items.count; i++)
        NG_TRY(read_libraries(m, m->libraries.items.items[i]));
    NG_TRY(note_missing(m));
    m->plain = -1;
    return NG_OK;
}

uint32_t ng_obj_plain_material(struct obj_model *m)
{
    if (m->plain >= 0)
        return (uint32_t)m->plain;
    m->plain = (int)ng_obj_begin(&m->glb, OBJ_MATERIALS);
    ng_obj_item(
        &m->glb, OBJ_MATERIALS,
        "{\"name\":\"plain\",\"doubleSided\":true,\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.6,0.6,"
        "0.6,1],\"metallicFactor\":0,\"roughnessFactor\":0.7}}");
    return (uint32_t)m->plain;
}
