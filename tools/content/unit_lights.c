// One scene a light type, all with the same props.
#include "content.h"
#include "stage.h"
#include "texture.h"

static const double white[3] = {1, 1, 1};
static const double quarter = 0.70710678118654752;

ng_result unit_light_point(struct bytes *out)
{
    struct glb g;
    stage_init(&g);
    stage_add_wall(&g);
    stage_add_props(&g);
    int light = glb_add_light(&g, "point", "point", (const double[3]){1.0, 0.85, 0.6}, 8.0, 0, 0);
    glb_add_node(&g, &(struct glb_node){.name = "point", .translation = {0.4, 2.2, 1.4}, .light = light + 1});
    return glb_finish(&g, out);
}

ng_result unit_light_spot(struct bytes *out)
{
    struct glb g;
    stage_init(&g);
    stage_add_wall(&g);
    stage_add_props(&g);
    int light = glb_add_light(&g, "spot", "spot", white, 25.0, 0.25, 0.45);
    // From the front left above, towards the sphere.
    const double turn = 0.5 * atan2(-1.5, 2.0), down = 0.5 * -0.72;
    glb_add_node(&g, &(struct glb_node){.name = "spot",
                                        .translation = {-1.5, 2.7, 2.3},
                                        .rotation = {cos(turn) * sin(down), sin(turn) * cos(down),
                                                     -sin(turn) * sin(down), cos(turn) * cos(down)},
                                        .light = light + 1});
    return glb_finish(&g, out);
}

ng_result unit_light_directional(struct bytes *out)
{
    struct glb g;
    stage_init(&g);
    stage_add_wall(&g);
    stage_add_props(&g);
    int light = glb_add_light(&g, "sun", "directional", (const double[3]){1.0, 0.95, 0.85}, 2.5, 0, 0);
    const double turn = 0.5 * 0.7, down = 0.5 * -0.8;
    glb_add_node(&g, &(struct glb_node){.name = "sun",
                                        .rotation = {cos(turn) * sin(down), sin(turn) * cos(down),
                                                     -sin(turn) * sin(down), cos(turn) * cos(down)},
                                        .light = light + 1});
    return glb_finish(&g, out);
}

// A node with a light component, turned to shine down.
static cJSON *add_area(struct glb *g, const char *component, double radiance)
{
    int node = glb_add_node(g, &(struct glb_node){.name = component,
                                                  .translation = {0.3, 2.2, 0.4},
                                                  .rotation = {-quarter, 0, 0, quarter}});
    cJSON *light = glb_component(g, NG_GLTF_NODES, node, component);
    glb_set(g, light, "radiance", radiance);
    return light;
}

ng_result unit_light_rectangle(struct bytes *out)
{
    struct glb g;
    stage_init(&g);
    stage_add_wall(&g);
    stage_add_props(&g);
    glb_set_list(&g, add_area(&g, "light_rectangle", 16.0), "size", (const double[2]){1.6, 0.7}, 2);
    return glb_finish(&g, out);
}

ng_result unit_light_rectangle_textured(struct bytes *out)
{
    struct glb g;
    stage_init(&g);
    stage_add_wall(&g);
    stage_add_props(&g);
    cJSON *light = add_area(&g, "light_rectangle", 30.0);
    glb_set_list(&g, light, "size", (const double[2]){1.4, 1.4}, 2);
    glb_set_texture(&g, light, "texture", glb_texture(&g, "panes", texture_panes, GLB_CLAMP));
    return glb_finish(&g, out);
}

ng_result unit_light_disk(struct bytes *out)
{
    struct glb g;
    stage_init(&g);
    stage_add_wall(&g);
    stage_add_props(&g);
    glb_set(&g, add_area(&g, "light_disk", 18.0), "radius", 0.55);
    return glb_finish(&g, out);
}

ng_result unit_light_sphere(struct bytes *out)
{
    struct glb g;
    stage_init(&g);
    stage_add_wall(&g);
    stage_add_props(&g);
    glb_set(&g, add_area(&g, "light_sphere", 14.0), "radius", 0.3);
    return glb_finish(&g, out);
}

ng_result unit_light_mesh(struct bytes *out)
{
    struct glb g;
    stage_init(&g);
    stage_add_wall(&g);
    stage_add_props(&g);
    int material = glb_add_material(
        &g,
        &(struct glb_material){.name = "glow",
                               .base_color = {0.1, 0.1, 0.1},
                               .roughness = 0.5,
                               .emissive = {14, 12, 9},
                               .emissive_texture = glb_texture(&g, "panes", texture_panes, GLB_REPEAT) + 1});
    int node = stage_place(&g, "lantern", stage_sphere(&g, "lantern", 0.35, material), 0.3, 2.0, 0.8);
    glb_set(&g, glb_component(&g, NG_GLTF_NODES, node, "light_mesh"), "scale", 1.0);
    return glb_finish(&g, out);
}

ng_result unit_light_environment(struct bytes *out)
{
    struct glb g;
    stage_init(&g);
    stage_add_wall(&g);
    stage_add_props(&g);
    // Turned by a third about the vertical, so that a map that ignores its rotation shows.
    const double turn = CONTENT_PI / 3.0;
    int node = glb_add_node(&g, &(struct glb_node){.name = "sky", .rotation = {0, sin(turn), 0, cos(turn)}});
    cJSON *light = glb_component(&g, NG_GLTF_NODES, node, "light_environment");
    glb_set(&g, light, "intensity", 1.0);
    glb_set_picture(&g, light, "map", "environment.hdr");
    return glb_finish(&g, out);
}

ng_result unit_environment_hdr(struct bytes *out)
{
    return texture_sky(out);
}
