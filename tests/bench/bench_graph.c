// Time to declare and compile a frame of N passes without a device, and its share per pass.
#include "base/system.h"
#include "graph/graph.h"
#include "graph/plan.h"

#include <stdio.h>
#include <stdlib.h>

static ng_result nothing(const struct ng_pass_context *ctx)
{
    NG_UNUSED(ctx);
    return NG_OK;
}

// A chain in which each pass reads three earlier images and writes two.
static bool frame(struct ng_graph *g, int passes)
{
    struct ng_graph_ref images[4] = {0};
    const struct ng_graph_image_params p = {
        .format = VK_FORMAT_R16G16B16A16_SFLOAT, .width = 512, .height = 512, .clear = true};
    char name[32];
    ng_graph_begin(g);
    for (int i = 0; i < 4; i++) {
        snprintf(name, sizeof name, "start%d", i);
        images[i] = ng_graph_add_image(g, name, &p);
    }
    for (int i = 0; i < passes; i++) {
        snprintf(name, sizeof name, "group/pass%d", i);
        struct ng_pass *pass = ng_graph_add_pass(
            g, &(struct ng_pass_params){.name = name, .kind = NG_PASS_RASTER, .run = nothing});
        for (int k = 1; k < 4; k++)
            ng_pass_read(pass, images[(i + k) % 4], NG_USE_SAMPLED);
        snprintf(name, sizeof name, "image%d", i);
        images[i % 4] = ng_pass_write(pass, ng_graph_add_image(g, name, &p), NG_USE_COLOR);
        snprintf(name, sizeof name, "extra%d", i);
        ng_pass_write(pass, ng_graph_add_image(g, name, &p), NG_USE_COLOR);
    }
    ng_graph_export(g, images[(passes - 1) % 4]);
    return ng_graph_compile(g) == NG_OK;
}

int main(void)
{
    struct ng_graph *g = NULL;
    if (ng_graph_create(NULL, &g) != NG_OK)
        return 1;
    double ms[2] = {1e30, 1e30};
    const int passes[2] = {100, 400};
    for (int size = 0; size < 2; size++)
        for (int round = 0; round < 50; round++) {
            uint64_t start = ng_clock_ns();
            if (!frame(g, passes[size]))
                return 1;
            double t = (double)(ng_clock_ns() - start) * 1e-6;
            ms[size] = t < ms[size] ? t : ms[size];
        }
    printf("{\"compile_ms_100\": %.3f, \"compile_ms_400\": %.3f, \"ratios\": {\"graph_400_to_100\": %.2f}}\n",
           ms[0], ms[1], ms[1] / ms[0]);
    ng_graph_destroy(&g);
    return 0;
}
