// The caches of the scene on the GPU, keyed by the snapshot's keys and revisions: geometry (scene_meshes.c)
// and textures (scene_images.c). scene_gpu.c draws with them.
#ifndef NG_RENDER_SCENE_GPU_INTERNAL_H
#define NG_RENDER_SCENE_GPU_INTERNAL_H

#include "base/array.h"
#include "gpu/frame.h"
#include "render/index_map.h"
#include "render/scene_gpu.h"

#define NG_SCENE_UNUSED_FRAMES 120 // frames after which what nobody asks for is dropped

// ---- geometry --------------------------------------------------------------------------------------------
// The parts of a mesh's buffer; the last is there for meshes that deform only.
enum ng_mesh_stream {
    NG_STREAM_POSITION,
    NG_STREAM_NORMAL,
    NG_STREAM_TANGENT,
    NG_STREAM_UV,
    NG_STREAM_UV1,   // empty where the mesh has none
    NG_STREAM_COLOR, // of one vertex, white, where it has none and might be asked for it
    NG_STREAM_INDEX,
    NG_STREAM_PREVIOUS,
    NG_STREAM_COUNT
};

struct ng_mesh_entry {
    uint64_t key, revision, last_used;
    uint32_t vertex_count, index_count;
    struct ng_gpu_buffer *buffers[NG_GPU_FRAMES]; // dynamic meshes take turns
    uint32_t current;
    uint64_t offsets[NG_STREAM_COUNT];
    bool has_uvs1, has_colors;
    bool moved; // dynamic: the previous positions are those of another revision
};

struct ng_mesh_cache {
    struct ng_gpu *gpu;
    NG_ARRAY(struct ng_mesh_entry) entries;
    struct ng_index_map at; // entries by key
    NG_ARRAY(uint32_t) of;  // entries of the snapshot's meshes
};

void ng_mesh_cache_finish(struct ng_mesh_cache *c);
// Drops what was last asked for before a frame.
void ng_mesh_cache_drop(struct ng_mesh_cache *c, uint64_t oldest);
// Brings all meshes of a snapshot to the GPU. Of a mesh whose points alone are others nothing is created:
// they are staged, and copied into its buffer ahead of the frame's commands and behind those of earlier
// frames.
NG_NODISCARD ng_result ng_mesh_cache_update(struct ng_mesh_cache *c, const struct ng_snapshot *snapshot,
                                            uint64_t frame);
// Binds the streams and the indices of a mesh of the snapshot.
void ng_mesh_cache_bind(const struct ng_mesh_cache *c, struct ng_cmd *cmd, uint32_t mesh,
                        enum ng_vertex_streams streams);

// ---- textures --------------------------------------------------------------------------------------------
struct ng_image_entry {
    uint64_t key, revision, last_used;
    struct ng_gpu_image *image;
    VkSampler sampler;
};

struct ng_group_entry {
    uint64_t key, last_used; // hash of the image keys
    struct ng_gpu_bind_group *group;
};

struct ng_texture_cache {
    struct ng_gpu *gpu;
    const struct ng_snapshot *snapshot;
    uint64_t frame;
    NG_ARRAY(struct ng_image_entry) images;
    NG_ARRAY(struct ng_group_entry) groups;
    struct ng_index_map image_at, group_at; // entries by key
    NG_ARRAY(uint32_t) of;                  // entries of the snapshot's images
    struct ng_gpu_image *white, *black;     // one texel each
};

NG_NODISCARD ng_result ng_texture_cache_init(struct ng_texture_cache *c, struct ng_gpu *gpu);
void ng_texture_cache_finish(struct ng_texture_cache *c);
void ng_texture_cache_drop(struct ng_texture_cache *c, uint64_t oldest);
// Brings all images of a snapshot to the GPU. One that was edited is uploaded into its image, if that has its
// size and format; else it gets another.
NG_NODISCARD ng_result ng_texture_cache_update(struct ng_texture_cache *c, const struct ng_snapshot *snapshot,
                                               uint64_t frame);
struct ng_gpu_binding ng_texture_cache_image(const struct ng_texture_cache *c, uint32_t image,
                                             uint32_t binding);
// How an image is sampled; null on failure (logged).
VkSampler ng_texture_cache_sampler(struct ng_gpu *gpu, const struct ng_image *image, float anisotropy);
bool ng_material_is_textured(const struct ng_snapshot_material *m);
// Whether some texture is not looked up where the mesh's first texture coordinates say.
bool ng_material_chooses_uvs(const struct ng_snapshot_material *m, bool mesh_has_second);
// Hash of the images of a material; never 0.
uint64_t ng_texture_cache_group_key(const struct ng_texture_cache *c, const struct ng_snapshot_material *m);
// The bind group of a material's textures, made when a draw first needs it.
NG_NODISCARD ng_result ng_texture_cache_group(struct ng_texture_cache *c,
                                              const struct ng_snapshot_material *m,
                                              const struct ng_gpu_pipeline *pipeline,
                                              const struct ng_gpu_bind_group **out);

#endif
