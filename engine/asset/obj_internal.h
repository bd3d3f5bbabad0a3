// Wavefront OBJ with MTL, made into a GLB in memory, which is then loaded as any other: rules, limits,
// warnings and saving are glTF's. obj_text.cc reads the lines, obj.c keeps what they say, obj_faces.c and
// obj_surface.c make primitives of it, obj_material.c materials, obj_glb.c writes. Source: B1 Object Files
// (Wavefront, 1992) and what programs write today.
#ifndef NG_ASSET_OBJ_INTERNAL_H
#define NG_ASSET_OBJ_INTERNAL_H

#include "asset/gltf_internal.h"
#include "base/array.h"
#include "base/extern_c.h"

NG_EXTERN_C_BEGIN

// ---- what is asked for -----------------------------------------------------------------------------------
// How a furniture catalogue wants a model: turned, its box scaled to a size, standing on the floor about the
// origin.
struct obj_fit {
    float rotation[9]; // rows of an orthogonal matrix
    float size[3];     // x, y, z, metres
};

struct obj_source {
    const char *text;
    size_t size;
    const char *title, *copyright; // may be null
    const struct obj_fit *fit;     // null: as it is
    // The bytes of a file that the text names, from malloc. Errors are logged.
    ng_result (*read)(void *user, const char *name, void **data, size_t *size);
    void *user;
};

// Whether a text begins as an OBJ file does.
bool ng_obj_is(const char *text, size_t size);
// The GLB, from malloc. What can be done without is a fault.
NG_NODISCARD ng_result ng_obj_glb(struct gltf_faults *faults, const struct ng_gltf_params *params,
                                  const struct obj_source *source, unsigned char **glb, size_t *size);
// The same of a file whose text was read: what it names lies beside it.
NG_NODISCARD ng_result ng_obj_file_glb(struct gltf_faults *faults, const struct ng_gltf_params *params,
                                       const char *text, size_t text_size, unsigned char **glb, size_t *size);

// ---- obj_text.cc -----------------------------------------------------------------------------------------
// What lines say, in their order. Indices of corners (v, vt, vn) are the file's: from 1, or below 0 from the
// end; 0 is none. Texts end with the call.
struct obj_events {
    void (*vertex)(void *user, const float position[3]);
    void (*color)(void *user, const float rgb[3]); // of the next vertex
    void (*normal)(void *user, const float normal[3]);
    void (*texcoord)(void *user, const float uv[2]);
    void (*face)(void *user, const int (*corners)[3], size_t count);
    void (*smoothing)(void *user, unsigned group); // 0: off
    void (*material)(void *user, const char *name);
    void (*object)(void *user, const char *name);
    void (*group)(void *user, const char *name);
    void (*library)(void *user, const char *names); // of MTL files
    void (*skipped)(void *user);                    // points, lines, curves
    bool (*stop)(void *user);                       // asked at each line
    void *user;
};
NG_NODISCARD ng_result ng_obj_lines(const char *path, const char *text, size_t size,
                                    const struct obj_events *events);

struct obj_map {
    const char *name; // "" if none
    float scale[2], offset[2];
    float bump; // strength of a normal map
    bool clamp;
};
struct obj_material {
    const char *name;
    float diffuse[3], specular[3], emission[3];
    float shininess, dissolve, ior, roughness, metallic; // the last two: 0 if not given
    int illum;
    struct obj_map diffuse_map, alpha_map, bump_map, normal_map, emission_map;
    const char *unfollowed; // the first map that has no place in ours; null if none
};
NG_NODISCARD ng_result ng_obj_materials(const char *path, const char *text, size_t size,
                                        void (*each)(void *user, const struct obj_material *m), void *user);

// ---- obj_glb.c: a GLB that grows --------------------------------------------------------------------------
struct obj_text {
    char *items;
    size_t count, capacity;
};
enum obj_list {
    OBJ_NODES,
    OBJ_MESHES,
    OBJ_MATERIALS,
    OBJ_TEXTURES,
    OBJ_IMAGES,
    OBJ_SAMPLERS,
    OBJ_ACCESSORS,
    OBJ_VIEWS,
    OBJ_LIST_COUNT
};
struct obj_glb {
    struct {
        struct obj_text text;
        uint32_t count;
    } lists[OBJ_LIST_COUNT];
    struct obj_text bytes;
    uint64_t limit;                    // of all bytes
    bool uses_specular, uses_strength; // extensions; the second comes with the first
    bool failed;                       // out of memory, or over the limit
};
void ng_obj_glb_finish(struct obj_glb *glb);
void ng_obj_text(struct obj_text *t, bool *failed, const char *fmt, ...) NG_PRINTF(3, 4);
// A JSON string, quoted; what is not UTF-8 is taken as Latin-1.
void ng_obj_string(struct obj_text *t, bool *failed, const char *text);
// Begins an item of a list and gives its index; its text goes to ng_obj_item.
uint32_t ng_obj_begin(struct obj_glb *glb, enum obj_list list);
#define ng_obj_item(glb, list, ...) ng_obj_text(&(glb)->lists[list].text, &(glb)->failed, __VA_ARGS__)
void ng_obj_item_string(struct obj_glb *glb, enum obj_list list, const char *text);
void ng_obj_append(struct obj_glb *glb, enum obj_list list, const struct obj_text *text);
uint32_t ng_obj_view(struct obj_glb *glb, const void *data, size_t size);
// `more`: other members, each after a comma.
uint32_t ng_obj_accessor(struct obj_glb *glb, const void *data, size_t count, unsigned width, int type,
                         const char *more);
// `roots`: the scene's nodes, indices with commas between.
NG_NODISCARD ng_result ng_obj_glb_end(struct obj_glb *glb, const char *path, const char *title,
                                      const char *copyright, const struct obj_text *roots,
                                      unsigned char **out, size_t *size);

// ---- obj.c: what the lines said ---------------------------------------------------------------------------
struct obj_names { // texts, each once
    NG_ARRAY(char *) items;
    NG_ARRAY(uint32_t) slots; // index plus 1; a power of two
};
// The index of a text, added if it is not there; UINT32_MAX when out of memory.
uint32_t ng_obj_name(struct obj_names *names, const char *text);
void ng_obj_names_finish(struct obj_names *names);

struct obj_corner {
    int32_t v, t, n; // from 0; -1: none
};
struct obj_face {
    uint32_t corner, count;
    uint32_t part, material; // material: UINT32_MAX if none
    uint32_t smoothing;
};
// An object, or a group within one.
struct obj_part {
    uint32_t name, object; // names; object UINT32_MAX: it is one, or within none
    uint32_t node;         // plus 1
    uint32_t mesh;         // plus 1
};
struct obj_material_use {
    int gltf; // index of the material; -1: no library has it
    struct obj_map diffuse_map;
};
struct obj_model {
    struct gltf_faults *faults;
    const struct ng_gltf_params *params;
    const struct obj_source *source;
    ng_result result;
    NG_ARRAY(float) positions;
    NG_ARRAY(float) colors; // as positions, or fewer
    NG_ARRAY(float) normals;
    NG_ARRAY(float) uvs;
    NG_ARRAY(struct obj_corner) corners;
    NG_ARRAY(struct obj_face) faces;
    struct obj_names part_names, material_names, libraries;
    NG_ARRAY(struct obj_part) parts;
    NG_ARRAY(struct obj_material_use) materials; // by material_names
    int plain;                                   // the material of faces without one; -1: not made
    uint32_t object, part, material;             // current
    unsigned smoothing;
    float color[3];
    bool has_color, skipped;
    bool has_library; // one that could be read
    struct obj_glb glb;
    struct obj_names textures; // files; by these:
    NG_ARRAY(int) images;      // -1: it is missing
    NG_ARRAY(bool) alphas;     // it has transparent parts
};

// ---- obj_material.c, obj_bump.c, obj_surface.c, obj_triangles.c
// ------------------------------------------------------- Reads the libraries, writes the materials that
// faces use.
NG_NODISCARD ng_result ng_obj_write_materials(struct obj_model *m);
uint32_t ng_obj_plain_material(struct obj_model *m);
// Drops faces that cannot be drawn; an error if none is left.
NG_NODISCARD ng_result ng_obj_drop_faces(struct obj_model *m);
// Gives a normal to each corner that has none.
NG_NODISCARD ng_result ng_obj_make_normals(struct obj_model *m);
const float *ng_obj_position(const struct obj_model *m, int32_t v);
// Twice the area of a face, times its normal (Newell's method).
void ng_obj_area(const struct obj_model *m, const struct obj_face *f, double out[3]);
// Does both, writes meshes of the parts.
NG_NODISCARD ng_result ng_obj_write_meshes(struct obj_model *m);
// The two nodes above all others that fit the model: one scales and moves, below it one turns.
void ng_obj_write_fit(struct obj_model *m, const struct obj_text *children);

// Makes a normal map of the bytes of a picture of heights, which it replaces. Another picture stays.
NG_NODISCARD ng_result ng_obj_normal_map(const char *name, const struct ng_gltf_params *params, void **data,
                                         size_t *size);

struct obj_polygon {
    const double (*points)[2]; // counter-clockwise
    uint32_t count;            // at least 3
    uint32_t *links;           // room for 2 * count
    uint64_t *work;            // comparisons that are left for all polygons; without it they become fans
};
// Writes 3 * (count - 2) corners.
void ng_obj_triangles(const struct obj_polygon *p, uint32_t *out);

NG_EXTERN_C_END

#endif
