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

// What lights are made of: for each, seven passes in a row with a persistent image each, and an image that
// all lights add to.
static bool lights(struct ng_graph *g, int count)
{
    const struct ng_graph_image_params p = {
        .format = VK_FORMAT_R16G16B16A16_SFLOAT, .width = 64, .height = 64, .clear = true};
    char name[48];
    ng_graph_begin(g);
    struct ng_graph_ref sum = ng_graph_add_image(g, "sum", &p);
    for (int i = 0; i < count; i++) {
        struct ng_graph_ref last = {0};
        for (int k = 0; k < 7; k++) {
            snprintf(name, sizeof name, "encode:lamp#%d/%d", i, k);
            struct ng_pass *pass = ng_graph_add_pass(
                g,
                &(struct ng_pass_params){
                    .name = name, .kind = NG_PASS_RASTER, .run = nothing, .key = (uint64_t)(i * 7 + k + 1)});
            if (k)
                ng_pass_read(pass, last, NG_USE_SAMPLED);
            if (k == 6)
                sum = ng_pass_write(pass, sum, NG_USE_COLOR);
            else if (k % 2)
                last = ng_pass_write(pass, ng_graph_add_image(g, name, &p), NG_USE_COLOR);
            else
                last = ng_pass_write(pass, ng_graph_persistent_image(g, name, &p, NULL), NG_USE_COLOR);
        }
    }
    ng_graph_export(g, sum);
    return ng_graph_compile(g) == NG_OK;
}

static double measure(struct ng_graph *g, bool (*declare)(struct ng_graph *, int), int size, int rounds)
{
    double best = 1e30;
    for (int round = 0; round < rounds; round++) {
        uint64_t start = ng_clock_ns();
        if (!declare(g, size))
            exit(1);
        double ms = (double)(ng_clock_ns() - start) * 1e-6;
        best = ms < best ? ms : best;
    }
    return best;
}

int main(void)
{
    struct ng_graph *g = NULL;
    if (ng_graph_create(NULL, &g) != NG_OK)
        return 1;
    double small = measure(g, frame, 100, 50), middle = measure(g, frame, 400, 50);
    double large = measure(g, frame, 1500, 20);
    double some = measure(g, lights, 1023, 3), most = measure(g, lights, 4095, 3);
    printf("{\"compile_ms_100\": %.3f, \"compile_ms_400\": %.3f, \"compile_ms_1500\": %.3f, "
           "\"compile_ms_1023_lights\": %.1f, \"compile_ms_4095_lights\": %.1f, "
           "\"ratios\": {\"graph_400_to_100\": %.2f, \"graph_1500_to_100\": %.2f, "
           "\"graph_4095_to_1023_lights\": %.2f}}\n",
           small, middle, large, some, most, middle / small, large / small, most / some);
    ng_graph_destroy(&g);
    return 0;
}
