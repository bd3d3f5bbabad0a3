// Primitives that share vertices with many others: each reads those alone that its triangles use.
#include "asset/gltf_loader_internal.h"
#include "base/log.h"

#include <stdlib.h>
#include <string.h>

static int compare(const void *a, const void *b)
{
    const uint32_t *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

// The place of a vertex in the set; one that the file does not have keeps its number, which is beyond the
// set.
static uint32_t place_of(const struct gltf_subset *s, uint32_t vertex)
{
    const uint32_t *found = bsearch(&vertex, s->vertices, s->count, sizeof *s->vertices, compare);
    return found ? (uint32_t)(found - s->vertices) : vertex;
}

ng_result ng_gltf_choose_vertices(struct gltf_loader *l, struct ng_geometry *g, size_t vertex_count,
                                  struct gltf_subset *out)
{
    *out = (struct gltf_subset){.of = (uint32_t)vertex_count};
    if (vertex_count > UINT32_MAX || g->index_count >= vertex_count / 4)
        return NG_OK;
    uint32_t *sorted = malloc(g->index_count * sizeof *sorted);
    if (!sorted)
        return ng_out_of_memory(l->path);
    memcpy(sorted, g->indices, g->index_count * sizeof *sorted);
    qsort(sorted, g->index_count, sizeof *sorted, compare);
    for (uint32_t i = 0; i < g->index_count && sorted[i] < vertex_count; i++)
        if (i == 0 || sorted[i] != sorted[i - 1])
            sorted[out->count++] = sorted[i];
    out->vertices = sorted;
    if (out->count == 0) { // what is wrong is found by those who read all
        ng_gltf_forget_vertices(out);
        return NG_OK;
    }
    for (uint32_t i = 0; i < g->index_count; i++)
        g->indices[i] = place_of(out, g->indices[i]);
    return NG_OK;
}

void ng_gltf_forget_vertices(struct gltf_subset *s)
{
    free(s->vertices);
    s->vertices = NULL;
}
