// Layers: what a frame computed, fetched from the graph by name and converted to plain floats.
#include "render/renderer_internal.h"

#include "base/half.h"
#include "base/log.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// How a layer is made from a texel.
enum source { SOURCE_COPY, SOURCE_W, SOURCE_DEPTH, SOURCE_RATIO };

static const struct layer {
    struct ng_layer_info info;
    const char *resource; // of the graph; "radiance/...": the method's own (render/frame.h)
    enum source source;
} layers[] = {
    {{"beauty", {"R", "G", "B"}, false, "radiance: direct + indirect + emission, W/(sr m2)"},
     "beauty",
     SOURCE_COPY},
    {{"direct", {"R", "G", "B"}, false, "T_d: direct light with shadows"}, "radiance/direct", SOURCE_COPY},
    {{"unshadowed", {"R", "G", "B"}, false, "T_l: direct light as if nothing were in its way"},
     "radiance/unshadowed",
     SOURCE_COPY},
    {{"shadow", {"R", "G", "B"}, false, "T_ls = T_d / T_l; 1 where T_l is 0"},
     "radiance/direct",
     SOURCE_RATIO},
    {{"indirect", {"R", "G", "B"}, false, "T_i: everything after the first bounce"},
     "radiance/indirect",
     SOURCE_COPY},
    {{"emission", {"R", "G", "B"}, false, "what surfaces and the environment emit"},
     "gbuffer/emission",
     SOURCE_COPY},
    {{"albedo", {"R", "G", "B"}, false, "diffuse albedo"}, "gbuffer/diffuse", SOURCE_COPY},
    {{"specular", {"R", "G", "B"}, false, "specular reflectance at normal incidence, F0"},
     "gbuffer/specular",
     SOURCE_COPY},
    {{"position", {"X", "Y", "Z"}, false, "world position, m; 0 where there is no surface"},
     "gbuffer/position",
     SOURCE_COPY},
    {{"normal", {"X", "Y", "Z"}, false, "shading normal, world"}, "gbuffer/normal", SOURCE_COPY},
    {{"roughness", {"Y"}, false, "perceptual roughness; alpha is its square"}, "gbuffer/normal", SOURCE_W},
    {{"motion", {"X", "Y"}, false, "pixels, now - before, x right, y down"}, "gbuffer/motion", SOURCE_COPY},
    {{"depth", {"Z"}, false, "distance along the view axis, m; 0 where there is no surface"},
     "gbuffer/position",
     SOURCE_DEPTH},
    {{"entity", {"id"}, true, "index half of the entity's id; 0 where there is none"},
     "gbuffer/entity",
     SOURCE_COPY},
};

const struct ng_layer_info *ng_renderer_layer_info(uint32_t index)
{
    return index < NG_COUNT(layers) ? &layers[index].info : NULL;
}

static const struct layer *find(const char *name)
{
    for (size_t i = 0; i < NG_COUNT(layers); i++)
        if (strcmp(layers[i].info.name, name) == 0)
            return &layers[i];
    return NULL;
}

const struct ng_layer_info *ng_renderer_find_layer(const char *name)
{
    const struct layer *l = find(name);
    return l ? &l->info : NULL;
}

#define RADIANCE "radiance/"

static bool is_radiance(const char *resource)
{
    return strncmp(resource, RADIANCE, strlen(RADIANCE)) == 0;
}

struct resource_name {
    char text[64];
};

// What the graph calls a resource of the table above.
static struct resource_name name_in_graph(const char *resource, const char *method)
{
    struct resource_name name;
    if (is_radiance(resource))
        snprintf(name.text, sizeof name.text, "%s/%s", method, resource + strlen(RADIANCE));
    else
        snprintf(name.text, sizeof name.text, "%s", resource);
    return name;
}

ng_result ng_layers_request(struct ng_graph *g, const char *method, const char *name)
{
    if (strcmp(name, "display") == 0) {
        ng_graph_readback(g, "display");
        return NG_OK;
    }
    const struct layer *l = find(name);
    if (!l) {
        ng_log_error("layer \"%s\": there is no such layer", name);
        return NG_ERROR_NOT_FOUND;
    }
    ng_graph_readback(g, name_in_graph(l->resource, method).text);
    if (l->source == SOURCE_RATIO)
        ng_graph_readback(g, name_in_graph(RADIANCE "unshadowed", method).text);
    return NG_OK;
}

// ---- Texels ----------------------------------------------------------------------------------------------

static void load_texel(const struct ng_graph_memory *m, uint32_t x, uint32_t y, float out[4])
{
    const unsigned char *row = (const unsigned char *)m->data + (size_t)y * m->row_bytes;
    uint16_t halves[4];
    memset(out, 0, 4 * sizeof *out);
    switch (m->format) {
    case VK_FORMAT_R32G32B32A32_SFLOAT:
        memcpy(out, row + (size_t)x * 16, 16);
        break;
    case VK_FORMAT_R32G32_SFLOAT:
        memcpy(out, row + (size_t)x * 8, 8);
        break;
    case VK_FORMAT_R16G16B16A16_SFLOAT:
        memcpy(halves, row + (size_t)x * 8, 8);
        for (int i = 0; i < 4; i++)
            out[i] = ng_half_to_float(halves[i]);
        break;
    default:
        assert(false && "a layer's format is one of these");
    }
}

// What a layer is made of besides its own resource.
struct conversion {
    enum source source;
    struct ng_graph_memory texels, unshadowed;
    const struct ng_snapshot_camera *camera;
};

static void convert_texel(const struct conversion *c, uint32_t x, uint32_t y, float out[4])
{
    load_texel(&c->texels, x, y, out);
    switch (c->source) {
    case SOURCE_COPY:
        break;
    case SOURCE_W:
        out[0] = out[3];
        break;
    case SOURCE_DEPTH: {
        // The third row of the view matrix is the axis that points back at the viewer.
        float z = c->camera->view[14];
        for (int i = 0; i < 3; i++)
            z += c->camera->view[i * 4 + 2] * out[i];
        out[0] = out[3] > 0 || out[3] < 0 ? -z : 0;
        break;
    }
    case SOURCE_RATIO: {
        float whole[4];
        load_texel(&c->unshadowed, x, y, whole);
        for (int i = 0; i < 3; i++)
            out[i] = whole[i] > 0 ? out[i] / whole[i] : 1;
        break;
    }
    }
}

static ng_result fetch(struct ng_renderer *r, const char *layer, const char *resource,
                       struct ng_graph_memory *out)
{
    if (!ng_renderer_was_requested(r, layer)) {
        ng_log_error("layer \"%s\": the last frame was not asked for it", layer);
        return NG_ERROR_USAGE;
    }
    if (is_radiance(resource) && !ng_renderer_has_radiance(r, resource + strlen(RADIANCE))) {
        ng_log_error("layer \"%s\": the method \"%s\" does not compute it", layer, ng_renderer_method(r));
        return NG_ERROR_UNSUPPORTED;
    }
    return ng_graph_readback_get(ng_renderer_graph(r), name_in_graph(resource, ng_renderer_method(r)).text,
                                 out);
}

ng_result ng_renderer_layer(struct ng_renderer *r, const char *name, struct ng_layer *out)
{
    const struct layer *l = find(name);
    NG_REQUIRE(l, "there is no layer \"%s\"", name);
    struct conversion c = {.source = l->source, .camera = ng_renderer_camera(r)};
    NG_TRY(fetch(r, name, l->resource, &c.texels));
    if (l->source == SOURCE_RATIO)
        NG_TRY(fetch(r, name, RADIANCE "unshadowed", &c.unshadowed));
    uint32_t channels = 0;
    while (channels < 4 && l->info.channels[channels])
        channels++;
    *out = (struct ng_layer){
        .info = &l->info, .width = c.texels.width, .height = c.texels.height, .channels = channels};
    if (l->info.uint) {
        out->ids = c.texels.data;
        return NG_OK;
    }
    float *pixels =
        ng_renderer_scratch(r, l->info.name, (size_t)out->width * out->height * channels * sizeof(float));
    if (!pixels)
        return ng_out_of_memory("a layer of the picture");
    out->pixels = pixels;
    for (uint32_t y = 0; y < out->height; y++)
        for (uint32_t x = 0; x < out->width; x++, pixels += channels) {
            float texel[4];
            convert_texel(&c, x, y, texel);
            memcpy(pixels, texel, channels * sizeof(float));
        }
    return NG_OK;
}

ng_result ng_renderer_display(struct ng_renderer *r, const uint8_t **rgba, uint32_t *width, uint32_t *height)
{
    struct ng_graph_memory m;
    NG_TRY(fetch(r, "display", "display", &m));
    *rgba = m.data;
    *width = m.width;
    *height = m.height;
    return NG_OK;
}

ng_result ng_renderer_pick(struct ng_renderer *r, uint32_t x, uint32_t y, ng_entity *out)
{
    struct ng_graph_memory m;
    *out = (ng_entity){0};
    NG_TRY(fetch(r, "entity", "gbuffer/entity", &m));
    NG_REQUIRE(x < m.width && y < m.height, "pixel %u, %u is outside of %u x %u", x, y, m.width, m.height);
    uint32_t index;
    memcpy(&index, (const unsigned char *)m.data + (size_t)y * m.row_bytes + (size_t)x * 4, sizeof index);
    *out = ng_renderer_entity(r, index);
    return NG_OK;
}
