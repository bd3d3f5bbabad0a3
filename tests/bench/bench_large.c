// What a scene costs of ten times the triangles, with copies of one mesh and with meshes of their own:
// bench_large FOLDER [THINGS [TRIANGLES [WEIGHTS]]]. Scenes of THINGS and of ten times as many things of
// TRIANGLES each (4 of 250,000) are written to FOLDER, measured, and removed. For the rasterizer, for the
// neural method and for a split view of it and the path tracer if WEIGHTS names a network, and for rays
// alone: the seconds that the file, the first frame, and frames after edits take. Each runs in a process of
// its own, so that its peak memory is its own.
#define _DEFAULT_SOURCE // wait4
#include "large_scene.h"

#include "app/stage.h"
#include "base/log.h"
#include "base/system.h"
#include "components/components.h"
#include "components/mesh.h"
#include "components/name.h"
#include "components/transform.h"
#include "lightformer/methods/methods.h"
#include "lightformer/trace/tracer.h"
#include "scene/world.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#define SIDE   256u
#define ROUNDS 3u // the fastest of them counts

enum figure { LOAD, FIRST, NOTHING, MOVED, ADDED, REMOVED, MEMORY, FIGURES };
static const char *const figure_names[FIGURES] = {"load",  "first",   "nothing", "moved",
                                                  "added", "removed", "MiB"};

enum kind { RASTER, RAYS, NEURAL, SPLIT, KINDS };
static const char *const kind_names[KINDS] = {"raster", "rays", "neural", "split"};

struct subject {
    enum kind kind;
    struct ng_stage *stage;
    struct lf_method *method, *other;
    struct lf_tracer *tracer;
    ng_entity thing, extra;
};

static double seconds_since(uint64_t start)
{
    return (double)(ng_clock_ns() - start) * 1e-9;
}

static ng_entity find(const struct ng_world *world, const char *name)
{
    const ng_entity root = {0};
    for (ng_entity e = ng_world_first_child(world, root); !ng_entity_is_null(e);
         e = ng_world_next_below(world, root, e)) {
        const struct ng_name *n = ng_world_get(world, e, NG_NAME);
        if (n && strcmp(n->text, name) == 0)
            return e;
    }
    return root;
}

static ng_result open_subject(struct subject *s, const char *path, const char *weights)
{
    const struct ng_stage_params params = {.scene = path, .no_device = s->kind == RAYS};
    NG_TRY(ng_stage_create(&params, &s->stage));
    s->thing = find(s->stage->world, "thing 0");
    if (s->kind == RAYS)
        return lf_tracer_create(&s->tracer);
    struct lf_method_params method = {.name = s->kind == RASTER ? "raster" : "neural",
                                      .composer = ng_renderer_composer(s->stage->renderer),
                                      .jobs = s->stage->jobs,
                                      .weights = weights,
                                      .slice = 1e-9};
    NG_TRY(lf_method_create(&method, &s->method));
    method.name = "reference";
    return s->kind == SPLIT ? lf_method_create(&method, &s->other) : NG_OK;
}

static ng_result draw(struct subject *s)
{
    if (s->kind == RAYS) {
        NG_TRY(ng_stage_advance(s->stage, 0, NULL));
        return lf_tracer_update(s->tracer, s->stage->snapshot);
    }
    static const char *const layers[] = {"display"};
    const struct ng_shown split = {
        .comparison = NG_COMPARE_SPLIT, .other_method = "reference", .divider = 0.5f};
    const struct ng_stage_frame frame = {.width = SIDE,
                                         .height = SIDE,
                                         .method = s->kind == RASTER ? "raster" : "neural",
                                         .shown = s->kind == SPLIT ? split : (struct ng_shown){0},
                                         .layers = layers,
                                         .layer_count = NG_COUNT(layers)};
    const uint8_t *rgba;
    uint32_t width, height;
    NG_TRY(ng_stage_draw(s->stage, &frame));
    return ng_renderer_display(s->stage->renderer, &rgba, &width, &height); // waits
}

// ---- Edits -----------------------------------------------------------------------------------------------

static ng_result change_nothing(struct subject *s)
{
    NG_UNUSED(s);
    return NG_OK;
}

static ng_result move(struct subject *s)
{
    struct ng_transform *t = ng_world_edit(s->stage->world, s->thing, NG_TRANSFORM);
    NG_REQUIRE(t, "the scene has no thing to move");
    t->translation[1] += 0.01f;
    return NG_OK;
}

// One more of the first thing's mesh.
static ng_result add(struct subject *s)
{
    struct ng_world *world = s->stage->world;
    struct ng_transform t = *(const struct ng_transform *)ng_world_get(world, s->thing, NG_TRANSFORM);
    struct ng_mesh mesh = *(const struct ng_mesh *)ng_world_get(world, s->thing, NG_MESH);
    t.translation[2] += 0.7f;
    s->extra = ng_entity_create(world);
    NG_TRY(ng_world_add(world, s->extra, NG_TRANSFORM, &t));
    return ng_world_add(world, s->extra, NG_MESH, &mesh);
}

static ng_result remove_added(struct subject *s)
{
    return ng_entity_destroy(s->stage->world, s->extra);
}

static ng_result measure_edits(struct subject *s, double out[FIGURES])
{
    static const struct {
        enum figure figure;
        ng_result (*edit)(struct subject *s);
    } edits[] = {{NOTHING, change_nothing}, {MOVED, move}, {ADDED, add}, {REMOVED, remove_added}};
    for (uint32_t round = 0; round < ROUNDS; round++)
        for (size_t i = 0; i < NG_COUNT(edits); i++) {
            double *best = &out[edits[i].figure];
            NG_TRY(edits[i].edit(s));
            uint64_t start = ng_clock_ns();
            NG_TRY(draw(s));
            double seconds = seconds_since(start);
            *best = round == 0 || seconds < *best ? seconds : *best;
            NG_TRY(draw(s)); // what was left for the next frame: motion that ends
        }
    return NG_OK;
}

static ng_result measure(enum kind kind, const char *path, const char *weights, double out[FIGURES])
{
    struct subject s = {.kind = kind};
    uint64_t start = ng_clock_ns();
    NG_TRY(open_subject(&s, path, weights));
    out[LOAD] = seconds_since(start);
    start = ng_clock_ns();
    NG_TRY(draw(&s));
    out[FIRST] = seconds_since(start);
    return measure_edits(&s, out); // the process ends here: nothing is closed
}

// ---- Processes of their own
// --------------------------------------------------------------------------------

// Runs in a child: its figures come back through a pipe, its peak memory from the system.
static bool measure_alone(enum kind kind, const char *path, const char *weights, double out[FIGURES])
{
    int ends[2], status = 0;
    struct rusage usage;
    fflush(NULL);
    if (pipe(ends) != 0)
        return false;
    pid_t child = fork();
    if (child == 0) {
        double figures[FIGURES] = {0};
        bool ok = measure(kind, path, weights, figures) == NG_OK;
        _exit(ok && write(ends[1], figures, sizeof figures) == (ssize_t)sizeof figures ? 0 : 1);
    }
    close(ends[1]);
    bool ok = child > 0 && read(ends[0], out, FIGURES * sizeof *out) == (ssize_t)(FIGURES * sizeof *out);
    close(ends[0]);
    ok = child > 0 && wait4(child, &status, 0, &usage) == child && ok && status == 0;
    out[MEMORY] = ok ? (double)usage.ru_maxrss / 1024 : 0;
    return ok;
}

static bool write_alone(const struct large_scene *scene, const char *path)
{
    int status = 0;
    fflush(NULL);
    pid_t child = fork();
    if (child == 0)
        _exit(large_scene_write(scene, path) == NG_OK ? 0 : 1);
    return child > 0 && waitpid(child, &status, 0) == child && status == 0;
}

// ---- Telling ---------------------------------------------------------------------------------------------

static void print_row(const char *label, const char *kind, const double values[FIGURES])
{
    printf("%-24s %-8s", label, kind);
    for (int f = 0; f < FIGURES; f++)
        printf(f == MEMORY ? " %9.0f" : " %9.4f", values[f]);
    printf("\n");
    fflush(stdout);
}

static void print_growth(enum kind kind, double small[FIGURES], double large[FIGURES])
{
    printf("%-24s %-8s", "  growth", kind_names[kind]);
    for (int f = 0; f < FIGURES; f++)
        printf(" %9.2f", small[f] > 0 ? large[f] / small[f] : 0);
    printf("\n");
}

static bool measure_scene(const struct large_scene *scene, const char *path, const char *weights,
                          double out[KINDS][FIGURES])
{
    char label[64];
    bool ok = write_alone(scene, path);
    snprintf(label, sizeof label, "%.2f M, %s", scene->things * 1e-6 * scene->triangles,
             scene->copies ? "copies" : "own meshes");
    for (int kind = 0; kind < (weights ? KINDS : NEURAL) && ok; kind++) {
        ok = measure_alone((enum kind)kind, path, weights, out[kind]);
        print_row(label, kind_names[kind], out[kind]);
    }
    unlink(path);
    return ok;
}

int main(int argc, char **argv)
{
    char path[4096];
    if (argc < 2 || argc > 5) {
        fprintf(stderr, "usage: bench_large FOLDER [THINGS [TRIANGLES [WEIGHTS]]]\n");
        return 2;
    }
    snprintf(path, sizeof path, "%s/large.glb", argv[1]);
    struct large_scene scene = {.triangles = argc > 3 ? (uint32_t)atoi(argv[3]) : 250000};
    uint32_t things = argc > 2 ? (uint32_t)atoi(argv[2]) : 4;
    const char *weights = argc > 4 ? argv[4] : NULL;
    printf("%-24s %-8s", "seconds", "");
    for (int f = 0; f < FIGURES; f++)
        printf(" %9s", figure_names[f]);
    printf("\n");
    for (int copies = 1; copies >= 0; copies--) {
        double figures[2][KINDS][FIGURES] = {0};
        scene.copies = copies;
        for (int size = 0; size < 2; size++) {
            scene.things = size ? things * 10 : things;
            if (!measure_scene(&scene, path, weights, figures[size]))
                return 1;
        }
        for (int kind = 0; kind < (weights ? KINDS : NEURAL); kind++)
            print_growth((enum kind)kind, figures[0][kind], figures[1][kind]);
    }
    return 0;
}
