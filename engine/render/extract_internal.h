// What an extractor remembers, and the steps of an extraction in the order they run.
#ifndef NG_RENDER_EXTRACT_INTERNAL_H
#define NG_RENDER_EXTRACT_INTERNAL_H

#include "anim/morph.h"
#include "anim/skinning.h"
#include "asset/assets.h"
#include "asset/refiner.h"
#include "base/array.h"
#include "components/components.h"
#include "components/material.h"
#include "components/morph.h"
#include "render/extract.h"
#include "render/index_map.h"
#include "scene/query.h"
#include "scene/world.h"

#include <string.h>

// ---- shapes: triangles in object space, shared by instances ----------------------------------------------
struct ng_shape {
    uint64_t hash; // of what it was made from
    ng_asset geometry, cage_id;
    struct ng_asset_revision of_geometry, of_cage; // that it shows
    const struct ng_geometry *source;              // null: one of the engine's own
    struct ng_snapshot_mesh mesh;
    struct ng_refiner *refiner; // of subdivided shapes; else null
    struct ng_cage made_cage;   // where none is named
    const struct ng_cage *cage;
    float *memory;          // vertices of refined and of the engine's own shapes
    float *rest;            // of refined ones: positions at rest, once they differ
    uint32_t *own_indices;  // of the engine's own
    uint16_t *cage_joints;  // of skinned cages: [cage vertex_count][4]
    float *cage_weights;    // [cage vertex_count][4]
    uint16_t *cage_joints1; // four more of each, or null
    float *cage_weights1;
    // Of cages that morph: what the geometry's targets add to the cage's vertices, as in struct ng_geometry.
    uint32_t *cage_target_ends, *cage_delta_vertices;
    float *cage_deltas;
    uint32_t joints_needed; // 1 + the largest joint of a skinned geometry
    uint32_t index;         // among the snapshot's meshes
    bool used;
};

// ---- pieces: one a mesh entity, beside its instance -----------------------------------------------------
// What all meshes of a skeleton follow.
struct ng_pose {
    ng_asset skeleton;
    uint32_t joint_count;
    struct ng_joint_matrix *palette, *wanted; // the last that was another, this frame's; one more, of zeros
    float *joint_world;                       // [joint_count][16]
    uint64_t version;                         // of the palette; 0: not read yet
    bool used;
};

// A mesh with vertices of its own, since joints move it, or morph targets, or both.
struct ng_deformed {
    struct ng_pose *pose;    // null: no joints move it, its vertices are in object space
    bool made;               // once, with:
    uint64_t posed;          // version of the pose
    uint64_t posed_revision; // of the shape
    struct ng_morph weights; // of the geometry's targets, those that it has
    float *morphed;          // with targets and joints: positions, normals, tangents before joints move them,
                             // or control points
    float *cage;             // control points of a subdivided mesh
    float *positions[2], *normals, *tangents;
    float *memory; // all of the above
    int now;       // which positions are the current ones
    struct ng_snapshot_mesh mesh;
};

struct ng_piece {
    ng_entity entity, material;
    struct ng_shape *shape;
    uint64_t shape_key; // its mesh's key, which outlives it
    uint64_t shape_revision;
    uint64_t reflection; // revisions of the material that it shows; of emission 0 where a light tells it
    uint64_t emission;
    struct ng_deformed *deformed; // null: rigid
};

// ---- lights ----------------------------------------------------------------------------------------------
enum { NG_SHAPE_BUILTIN = NG_LIGHT_SHAPE_MESH }; // how many shapes of emitters are the engine's own

struct ng_light_slot {
    ng_entity entity;
    struct ng_light_source source;
    ng_asset image;          // texture or map that the source was prepared with
    uint64_t image_revision; // 0: it is missing
    uint64_t version;        // of the light; 0: not prepared yet
    uint64_t unit_version;
    uint64_t
        piece_version; // mesh lights: of the instance that the triangles are of, or a hash of all of them
    uint64_t looked;   // geometry_version at which a material's meshes were last looked through; 0: never
    NG_ARRAY(float) triangles;
    NG_ARRAY(float) uvs;
    struct ng_material material;          // of area lights: what they are made of, whatever they emit
    uint32_t emitter;                     // its index among the emitters' materials, or NG_NONE
    uint32_t shape;                       // which of the engine's own; NG_SHAPE_BUILTIN: none
    uint32_t instance;                    // of that shape, or NG_NONE
    uint32_t place;                       // the first light whose surface is where this one's is
    uint32_t next_in_place, next_in_cell; // NG_NONE: none
    uint64_t company;                     // hash of the lights in its place
    float power;
};

struct ng_material_record {
    ng_entity entity;                  // null: the default material
    struct ng_material value;          // textures that are missing are null
    uint64_t images[NG_TEXTURE_COUNT]; // revisions of their contents
    uint64_t reflection, emission;     // revisions: equal ones, of any records, mean that it looks the same
    uint64_t emitter;                  // of reflection, where a light shows it: no light is unlit
};

// Numbers that move when entities come and go, or change what they have.
struct ng_extract_counts {
    uint64_t meshes, placed, skinned, subdivided, materials, lights;
};

struct ng_extractor {
    struct ng_world *world;
    const struct ng_assets *assets;
    struct ng_jobs *jobs;
    uint32_t since;                           // tick of the previous extraction
    uint64_t clock;                           // source of keys, revisions and versions
    struct ng_asset_revision assets_revision; // of the store
    struct ng_extract_stats stats;
    uint64_t frames;  // extractions so far
    bool free_camera; // the previous one was of a camera in no world
    struct ng_extract_counts counts;

    struct ng_query *meshes, *placed, *skinned, *subdivided, *materials, *cameras, *scales;
    struct ng_query *lights[NG_COMPONENT_COUNT]; // in the order of ng_light_types, a component each
    uint32_t light_types;

    struct ng_shape *builtin[NG_SHAPE_BUILTIN];
    NG_ARRAY(struct ng_shape *) shapes;
    struct ng_index_map shape_of; // by hash

    NG_ARRAY(struct ng_piece) pieces;
    NG_ARRAY(struct ng_piece) old_pieces; // while listing
    struct ng_index_map piece_of;         // by entity
    NG_ARRAY(struct ng_pose *) poses;
    struct ng_index_map pose_of; // by skeleton
    NG_ARRAY(uint32_t) moved;    // instances whose flag and previous matrix are to be settled
    NG_ARRAY(struct ng_morph_params) morphing;
    NG_ARRAY(struct ng_skin_params) skinning;
    NG_ARRAY(uint32_t) posing; // pieces that are deformed this frame

    NG_ARRAY(struct ng_material_record) records; // 0: the default material
    NG_ARRAY(struct ng_material_record) old_records;
    struct ng_index_map material_of; // by entity: index of the record
    bool materials_changed, image_list_dirty;
    struct ng_index_map image_of; // by asset
    NG_ARRAY(ng_asset) image_ids; // beside `images`

    NG_ARRAY(struct ng_light_slot) slots;
    NG_ARRAY(struct ng_light_slot) old_slots;
    struct ng_index_map mesh_light_of; // entity of a mesh light, a mesh or a material: slot
    struct ng_index_map place_of; // cell of places and sizes: the last of the lights that have a place there

    struct ng_index_map warned; // of whom, about what
    bool has_scale;

    // The snapshot's arrays.
    NG_ARRAY(struct ng_snapshot_mesh) mesh_array;
    NG_ARRAY(struct ng_snapshot_instance) instances;
    NG_ARRAY(struct ng_snapshot_instance) old_instances;
    NG_ARRAY(struct ng_snapshot_image) images;
    NG_ARRAY(struct ng_snapshot_material) material_array;
    NG_ARRAY(struct ng_snapshot_light) light_array;
    struct ng_snapshot snapshot;
};

// ---- extract_shapes.c ------------------------------------------------------------------------------------
NG_NODISCARD ng_result ng_extract_make_builtin(struct ng_extractor *x);
// The shape of a mesh entity; null (after one warning) where its geometry is missing or cannot be refined.
NG_NODISCARD ng_result ng_extract_shape(struct ng_extractor *x, ng_entity e, struct ng_shape **out);
// Takes in points that were edited. Shapes whose topology was are left to ng_extract_mark_shapes.
NG_NODISCARD ng_result ng_extract_follow_shapes(struct ng_extractor *x);
// Drops shapes that no piece used since the mark, numbers the others.
void ng_extract_mark_shapes(struct ng_extractor *x);
void ng_extract_sweep_shapes(struct ng_extractor *x);
void ng_extract_finish_shapes(struct ng_extractor *x);

// ---- extract_materials.c ---------------------------------------------------------------------------------
// Reads material components that changed. `assets_changed`: textures may be others, or have come or gone.
// `*listed` is set where the list of materials is another.
NG_NODISCARD ng_result ng_extract_read_materials(struct ng_extractor *x, bool count_changed,
                                                 bool assets_changed, bool *listed);
// Index of an entity's material: 0, the default, where it has none.
uint32_t ng_extract_material_index(const struct ng_extractor *x, ng_entity material);
// Writes the snapshot's materials (the scene's, then the emitters') and images.
NG_NODISCARD ng_result ng_extract_write_materials(struct ng_extractor *x);
// True where the difference can be seen in how a surface reflects: everything but its emission.
bool ng_extract_reflects_differently(const struct ng_material *a, const struct ng_material *b);
// Fills in where a transform puts texture coordinates.
void ng_extract_coordinates(const struct ng_texture_transform *transform, struct ng_snapshot_texture *out);
// Whether light passes a surface of this material: it has holes, or covers a part only.
bool ng_extract_lets_through(const struct ng_material *m);
// Radiance before the texture; none of what is unlit.
void ng_extract_emission(const struct ng_material *m, float out[3]);

// ---- extract_pieces.c ------------------------------------------------------------------------------------
// Clears the marks of motion that the previous extraction set.
void ng_extract_settle(struct ng_extractor *x);
// Lists all mesh entities anew; pieces that stay keep their history.
NG_NODISCARD ng_result ng_extract_list_pieces(struct ng_extractor *x);
// Follows placements, materials and (`assets_changed`) shapes that changed.
NG_NODISCARD ng_result ng_extract_follow_pieces(struct ng_extractor *x, bool assets_changed);
// Marks an instance as changed in this extraction; `index` is its place in the snapshot.
NG_NODISCARD ng_result ng_extract_touch(struct ng_extractor *x, uint32_t index);
// The mesh that a piece shows.
const struct ng_snapshot_mesh *ng_extract_piece_mesh(const struct ng_piece *piece);
// 3x4 row-major from 4x4 column-major, within NG_PLACEMENT_MAX: sizes of lights multiply placements.
void ng_extract_rows(const float matrix[16], float rows[12]);
void ng_extract_bounds(struct ng_snapshot_instance *instance, const struct ng_snapshot_mesh *mesh);
void ng_extract_set_mirrored(struct ng_snapshot_instance *instance, const float matrix[16]);
// Column-major, identity where the entity has none.
const float *ng_extract_placement(const struct ng_extractor *x, ng_entity e);

// ---- extract_skins.c -------------------------------------------------------------------------------------
// Has a listed piece follow the targets of its geometry and the skin that its entity names, if it can: as the
// old one (or null) did, whose vertices it takes, or anew.
NG_NODISCARD ng_result ng_extract_deform_piece(struct ng_extractor *x, struct ng_piece *piece,
                                               struct ng_piece *old);
void ng_extract_free_deformed(struct ng_deformed **deformed);
// Drops poses that no piece was made to follow since the mark.
void ng_extract_mark_poses(struct ng_extractor *x);
void ng_extract_sweep_poses(struct ng_extractor *x);
void ng_extract_finish_poses(struct ng_extractor *x);
// Morphs, skins and refines what deformed.
NG_NODISCARD ng_result ng_extract_pose(struct ng_extractor *x);

// ---- extract_lights.c ------------------------------------------------------------------------------------
// Lists the lights; `*listed` is set where they are not the previous extraction's.
NG_NODISCARD ng_result ng_extract_list_lights(struct ng_extractor *x, bool count_changed, bool *listed);
// Sources, powers, versions, places and the instances of emitters; pieces must be up to date. `listed`: the
// lights are not the previous extraction's.
NG_NODISCARD ng_result ng_extract_update_lights(struct ng_extractor *x, bool listed);
// Whether a mesh light is of a material: of all its meshes, then.
bool ng_extract_lights_material(const struct ng_extractor *x, ng_entity light);
// The material that an area light shows: its own, with the radiance of all lights of its place for emission.
void ng_extract_emitter_material(const struct ng_extractor *x, const struct ng_light_slot *slot,
                                 struct ng_material *out);
void ng_extract_finish_lights(struct ng_extractor *x);
// extract_places.c: finds out which lights share a place; after any of them changed.
NG_NODISCARD ng_result ng_extract_place_lights(struct ng_extractor *x);
// True the first time it is asked about an entity (null: the scene) and a kind of warning.
enum ng_extract_warning {
    NG_WARN_GEOMETRY,
    NG_WARN_CAGE,
    NG_WARN_SKIN,
    NG_WARN_MORPH,
    NG_WARN_EMISSION,
    NG_WARN_SPHERE,
    NG_WARN_ENVIRONMENTS,
    NG_WARN_CAMERAS
};
bool ng_extract_warn_once(struct ng_extractor *x, ng_entity e, enum ng_extract_warning kind);
// Bit for bit: what is written again unchanged, NaN or not, is no change.
static inline bool ng_extract_same(const void *a, const void *b, size_t size)
{
    return memcmp(a, b, size) == 0;
}
// Exchanges two variables of one type.
#define NG_SWAP(a, b)                                                                                        \
    do {                                                                                                     \
        char swap_[sizeof(a)];                                                                               \
        memcpy(swap_, &(a), sizeof(a));                                                                      \
        memcpy(&(a), &(b), sizeof(a));                                                                       \
        memcpy(&(b), swap_, sizeof(a));                                                                      \
    } while (0)
// Name of an entity, for messages; "entity 12" if it has none.
const char *ng_extract_name(const struct ng_extractor *x, ng_entity e, char buffer[NG_TEXT_SIZE]);

#endif
