#include "vary.h"

#include <stdio.h>

void vary_add(struct glb *g, int parent, const struct vary *v)
{
    int node = glb_add_node(g, &(struct glb_node){.name = v->name, .parent = parent});
    cJSON *c = glb_component(g, NG_GLTF_NODES, node, "variation");
    glb_set_text(g, c, "kind", v->kind);
    if (v->field)
        glb_set_text(g, c, "field", v->field);
    if (v->node || v->material)
        glb_set_entity(g, c, "target", v->node ? "node" : "material", (v->node ? v->node : v->material) - 1);
    if (v->choice_count)
        glb_set(g, c, "choice_count", v->choice_count);
    for (int i = 0; i < v->choice_count; i++) {
        char key[24];
        snprintf(key, sizeof key, "choice_%d", i);
        glb_set_list(g, c, key, v->choices[i], 4);
    }
    if (!v->choice_count) {
        glb_set_list(g, c, "min", v->min, 4);
        glb_set_list(g, c, "max", v->max, 4);
    }
    if (!v->field && v->node) {
        glb_set_list(g, c, "look_min", v->look_min, 3);
        glb_set_list(g, c, "look_max", v->look_max, 3);
    }
}
