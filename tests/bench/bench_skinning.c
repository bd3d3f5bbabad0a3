// Skinning: 30 characters of 5,000 vertices and 40 joints, as one frame does it. Prints nanoseconds a vertex,
// the frame's milliseconds, and the ratio to copying the same bytes, all in one run.
#include "anim/skinning.h"
#include "base/jobs.h"
#include "base/rng.h"
#include "base/system.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CHARACTERS = 30, VERTICES = 5000, JOINTS = 40, FRAMES = 40 };

struct character {
    float world[JOINTS][16], inverse_bind[JOINTS][16];
    struct ng_joint_matrix palette[JOINTS];
    uint16_t joints[VERTICES][4];
    float weights[VERTICES][4];
    struct {
        float positions[VERTICES][3], normals[VERTICES][3], tangents[VERTICES][4];
    } in, out;
};

static void make_character(struct character *c, uint64_t seed)
{
    struct ng_rng rng = ng_rng_make(seed, 0);
    for (int j = 0; j < JOINTS; j++)
        for (int i = 0; i < 16; i++) {
            float unit = i % 5 ? 0.0f : 1.0f, noise = i % 4 < 3 ? ng_rng_range(&rng, -0.1f, 0.1f) : 0.0f;
            c->world[j][i] = c->inverse_bind[j][i] = unit + noise;
        }
    for (int i = 0; i < VERTICES; i++) {
        uint32_t near = (uint32_t)i * (JOINTS - 4) / VERTICES; // neighbours share joints, as in a real mesh
        for (uint32_t k = 0; k < 4; k++) {
            c->joints[i][k] = (uint16_t)(near + k);
            c->weights[i][k] = 0.25f;
        }
    }
    float *values = &c->in.positions[0][0];
    for (size_t i = 0; i < sizeof c->in / sizeof(float); i++)
        values[i] = ng_rng_range(&rng, -1, 1);
}

static void skin_frame(struct ng_jobs *jobs, struct character *characters)
{
    struct ng_skin_params params[CHARACTERS];
    for (int i = 0; i < CHARACTERS; i++) {
        struct character *c = &characters[i];
        ng_skin_palette(JOINTS, c->world[0], c->inverse_bind[0], c->palette);
        params[i] = (struct ng_skin_params){
            .vertex_count = VERTICES,
            .joint_count = JOINTS,
            .palette = c->palette,
            .joints = c->joints[0],
            .weights = c->weights[0],
            .positions = c->in.positions[0],
            .normals = c->in.normals[0],
            .tangents = c->in.tangents[0],
            .out_positions = c->out.positions[0],
            .out_normals = c->out.normals[0],
            .out_tangents = c->out.tangents[0],
        };
    }
    ng_skin_batch(jobs, params, CHARACTERS);
}

static void copy_frame(struct ng_jobs *jobs, struct character *characters)
{
    NG_UNUSED(jobs);
    for (int i = 0; i < CHARACTERS; i++)
        memcpy(&characters[i].out, &characters[i].in, sizeof characters[i].in);
}

// The best of several frames, nanoseconds.
static uint64_t time_frames(void (*frame)(struct ng_jobs *, struct character *), struct ng_jobs *jobs,
                            struct character *characters)
{
    uint64_t best = UINT64_MAX;
    for (int i = 0; i < FRAMES; i++) {
        uint64_t start = ng_clock_ns();
        frame(jobs, characters);
        uint64_t time = ng_clock_ns() - start;
        best = time < best ? time : best;
    }
    return best;
}

int main(void)
{
    static struct character characters[CHARACTERS];
    struct ng_jobs *jobs = NULL;
    if (ng_jobs_create(NULL, &jobs) != NG_OK)
        return 1;
    for (uint64_t i = 0; i < CHARACTERS; i++)
        make_character(&characters[i], i);
    uint64_t copy = time_frames(copy_frame, NULL, characters);
    uint64_t one = time_frames(skin_frame, NULL, characters), all = time_frames(skin_frame, jobs, characters);
    const double vertices = (double)CHARACTERS * VERTICES;
    printf("{\"characters\": %d, \"vertices\": %d, \"joints\": %d, \"threads\": %u,\n", CHARACTERS, VERTICES,
           JOINTS, ng_jobs_threads(jobs));
    printf(" \"ns_per_vertex\": {\"one_thread\": %.2f, \"all_threads\": %.2f},\n", (double)one / vertices,
           (double)all / vertices);
    printf(" \"frame_ms\": %.3f,\n", (double)all / 1e6);
    printf(" \"ratios\": {\"one_thread_to_copy\": %.2f, \"all_threads_to_one\": %.2f}}\n",
           (double)one / (double)copy, (double)all / (double)one);
    ng_jobs_destroy(&jobs);
    return 0;
}
