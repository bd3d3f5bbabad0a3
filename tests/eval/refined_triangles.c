// Writes the triangles that the engine makes of a scene's subdivision surfaces, in the space of their nodes:
// refined_triangles SCENE OUT.safetensors. Of each such node NAME: NAME.positions and NAME.normals [n][3],
// NAME.indices [m][3].
//
// A peer renderer takes everything else from the file itself, but a limit surface cut into other triangles
// would be another scene.
#include "app/stage.h"
#include "base/log.h"
#include "components/components.h"
#include "components/name.h"
#include "lightformer/tensors/tensors.h"
#include "render/snapshot.h"
#include "scene/world.h"

#include <stdio.h>
#include <string.h>

static ng_result add(struct lf_tensors *out, const char *node, const char *what, enum lf_dtype dtype,
                     uint32_t count, const void *values)
{
    char name[LF_TENSOR_NAME];
    const uint64_t shape[] = {count, 3};
    int length = snprintf(name, sizeof name, "%s.%s", node, what);
    if (length < 0 || (size_t)length >= sizeof name) {
        ng_log_error("%s: the name is too long for a tensor", node);
        return NG_ERROR_UNSUPPORTED;
    }
    void *to = lf_tensors_add(out, name, dtype, 2, shape);
    if (!to)
        return NG_ERROR_MEMORY;
    memcpy(to, values, (size_t)count * 3 * lf_dtype_size(dtype));
    return NG_OK;
}

static ng_result add_instance(struct lf_tensors *out, const struct ng_stage *stage,
                              const struct ng_snapshot_instance *instance)
{
    const struct ng_snapshot_mesh *mesh = &stage->snapshot->meshes[instance->mesh];
    const struct ng_name *name = ng_world_get(stage->world, instance->entity, NG_NAME);
    if (!ng_world_get(stage->world, instance->entity, NG_SUBDIVISION))
        return NG_OK;
    if (!name || mesh->dynamic) {
        ng_log_error("a subdivision surface %s", name ? "bends: its triangles are not in its node's space"
                                                      : "has no name to find its node by");
        return NG_ERROR_UNSUPPORTED;
    }
    NG_TRY(add(out, name->text, "positions", LF_F32, mesh->vertex_count, mesh->positions));
    NG_TRY(add(out, name->text, "normals", LF_F32, mesh->vertex_count, mesh->normals));
    return add(out, name->text, "indices", LF_I32, mesh->index_count / 3, mesh->indices);
}

static ng_result run(const char *scene, const char *path, struct ng_stage **stage, struct lf_tensors *out)
{
    struct ng_stage_params params = {.scene = scene, .threads = 1, .no_device = true};
    NG_TRY(ng_stage_create(&params, stage));
    NG_TRY(ng_stage_seek(*stage, 0, NULL));
    for (uint32_t i = 0; i < (*stage)->snapshot->instance_count; i++)
        NG_TRY(add_instance(out, *stage, &(*stage)->snapshot->instances[i]));
    return lf_tensors_write(out, path);
}

int main(int argc, char **argv)
{
    if (argc != 3) {
        fputs("refined_triangles SCENE OUT.safetensors\n", stderr);
        return 2;
    }
    struct ng_stage *stage = NULL;
    struct lf_tensors out = {0};
    ng_result result = run(argv[1], argv[2], &stage, &out);
    lf_tensors_finish(&out);
    ng_stage_destroy(&stage);
    return result == NG_OK ? 0 : 1;
}
