// OBJ and MTL files become what they say; each fault costs a part and one warning.
#include "scene_maker.h"

#include "asset/png.h"
#include "base/file.h"

#define TRIANGLE "v 0 0 0\nv 1 0 0\nv 0 1 0\n"

static ng_result load_params(struct loaded *l, const char *text, const struct ng_gltf_params *params)
{
    char path[256];
    put_file("scene.obj", text, strlen(text), path);
    return load_path(l, path, params);
}

static void load(struct loaded *l, const char *text)
{
    if (load_params(l, text, NULL) != NG_OK)
        fail_msg("%s", l->log.text);
}

// Loads with one warning that says `warning`; null: none.
static void load_warned(struct loaded *l, const char *text, const char *warning)
{
    load(l, text);
    if (l->log.warnings != (warning != NULL) || (warning && !strstr(l->log.text, warning)))
        fail_msg("\"%s\" where \"%s\" was expected", l->log.text, warning ? warning : "");
}

static void refused(const char *text, size_t size, ng_result result, const char *message)
{
    struct loaded l;
    char path[256];
    put_file("bad.obj", text, size, path);
    assert_int_equal(load_path(&l, path, NULL), result);
    if (l.log.errors != 1 || !strstr(l.log.text, message))
        fail_msg("\"%s\" where \"%s\" was expected", l.log.text, message);
    assert_int_equal(ng_world_entity_count(l.world), 0);
    finish(&l);
}

// ---- what is there ---------------------------------------------------------------------------------------
static void test_parts(void **state)
{
    NG_UNUSED(state);
    struct loaded l;
    load_warned(&l,
                "# comment\n" TRIANGLE "o table\nf 1 2 3\ng leg one\nf -3 -2 -1\no chair\nf 1 2 3\n"
                "g leg one\nf 1 2 3\no table\nf 2 3 1\n",
                NULL);
    ng_entity table = find(&l, "table", NG_MESH), chair = find(&l, "chair", NG_MESH);
    assert_int_equal(geometry_of(&l, table)->index_count, 6); // it went on
    assert_int_equal(geometry_of(&l, chair)->index_count, 3);
    ng_entity leg = ng_world_first_child(l.world, table);
    assert_string_equal(((const struct ng_name *)ng_world_get(l.world, leg, NG_NAME))->text, "leg one");
    assert_false(ng_entity_is_null(ng_world_first_child(l.world, chair)));
    assert_int_equal(l.scene.primitive_count, 4);
    finish(&l);
}

static void test_attributes(void **state)
{
    NG_UNUSED(state);
    struct loaded l;
    load_warned(&l,
                "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nvt 0 0\nvt 1 0\nvt 0 0.75\nvn 0 0 2\n"
                "o a\nf 1/1/1 2/2/1 3/3/1\n",
                NULL);
    const struct ng_geometry *g = geometry_of(&l, find(&l, "a", NG_MESH));
    assert_int_equal(g->vertex_count, 3);
    assert_true(g->normals[2] == 1);
    assert_true(g->uvs[1] == 1); // the bottom of the picture
    assert_true(g->uvs[5] == 0.25f);
    assert_non_null(g->colors);
    assert_int_equal(g->colors[0], UINT16_MAX);
    assert_int_equal(g->colors[1], 0);
    finish(&l);
}

// Windows' line ends, continued lines, no line end at the file's end, a byte order mark.
static void test_lines(void **state)
{
    NG_UNUSED(state);
    struct loaded l;
    load_warned(&l, "\xef\xbb\xbfv 0 0 0\r\nv 1 0 0\r\n\tv 0 \\\r\n 1 0\r\no  a b \r\nf 1 \\\n2 3", NULL);
    assert_int_equal(geometry_of(&l, find(&l, "a b", NG_MESH))->index_count, 3);
    finish(&l);
}

static void test_made_normals(void **state)
{
    NG_UNUSED(state);
    static const char roof[] = "v -1 0 0\nv -1 0 1\nv 0 1 0\nv 0 1 1\nv 1 0 0\nv 1 0 1\n";
    static const char *const smoothing[] = {"", "s off\n", "s 1\n"};
    for (size_t i = 0; i < NG_COUNT(smoothing); i++) {
        struct loaded l;
        char text[512];
        snprintf(text, sizeof text, "%so a\n%sf 1 2 4 3\nf 3 4 6 5\n", roof, smoothing[i]);
        load_warned(&l, text, NULL);
        const struct ng_geometry *g = geometry_of(&l, find(&l, "a", NG_MESH));
        assert_int_equal(g->vertex_count, i == 2 ? 6 : 8);
        for (uint32_t k = 0; k < g->vertex_count; k++) {
            float up = g->normals[k * 3 + 1];
            bool ridge = g->positions[k * 3 + 1] == 1;
            assert_true(fabsf(up - (i == 2 && ridge ? 1 : sqrtf(0.5f))) < 1e-5f);
        }
        finish(&l);
    }
}

// A normal of no length, or none for some corners, is made.
static void test_bad_normals(void **state)
{
    NG_UNUSED(state);
    struct loaded l;
    load_warned(&l, TRIANGLE "vn 0 0 0\nvn 0 1 0\no a\nf 1//1 2//1 3//1\nf 1//2 2 3\n", NULL);
    const struct ng_geometry *g = geometry_of(&l, find(&l, "a", NG_MESH));
    int along_z = 0;
    for (uint32_t i = 0; i < g->vertex_count; i++)
        along_z += g->normals[i * 3 + 2] == 1;
    assert_int_equal(along_z, 5);
    finish(&l);
}

// Regular stars, whose area is known, far from the origin and on each side of it.
static void test_polygons(void **state)
{
    NG_UNUSED(state);
    static const double places[][2] = {{0, 0}, {50, 30}, {-50, 30}, {-7, -90}};
    for (size_t i = 0; i < NG_COUNT(places); i++)
        for (int corners = 4; corners <= 64; corners += 2) {
            struct loaded l;
            char text[8192] = "o a\n";
            double area = 0, x[64], y[64];
            for (int k = 0; k < corners; k++) {
                double r = k % 2 ? 1 : 0.3, t = 6.283185307179586 * k / corners;
                x[k] = places[i][0] + r * cos(t);
                y[k] = places[i][1] + r * sin(t);
                snprintf(text + strlen(text), sizeof text - strlen(text), "v %.9g %.9g 0\n", x[k], y[k]);
            }
            snprintf(text + strlen(text), sizeof text - strlen(text), "f");
            for (int k = 0; k < corners; k++) {
                area += x[k] * y[(k + 1) % corners] - x[(k + 1) % corners] * y[k];
                snprintf(text + strlen(text), sizeof text - strlen(text), " %d", k + 1);
            }
            load_warned(&l, text, NULL);
            const struct ng_geometry *g = geometry_of(&l, find(&l, "a", NG_MESH));
            assert_int_equal(g->index_count, (corners - 2) * 3);
            assert_true(fabs(signed_area(g) - area) < 1e-3);
            for (uint32_t t = 0; t < g->index_count; t += 3) { // no triangle is turned over
                struct ng_geometry one = *g;
                one.indices = g->indices + t;
                one.index_count = 3;
                assert_true(signed_area(&one) > -1e-6);
            }
            finish(&l);
        }
}

// ---- materials -------------------------------------------------------------------------------------------
static void put_picture(const char *name, bool alpha)
{
    char path[256];
    const unsigned char pixels[16] = {255, 0, 0, 255, 0, 255, 0, 0, 0, 0, 255, 255, 9, 9, 9, 0};
    test_path(path, sizeof path, name);
    assert_int_equal(ng_png_write(path, &(struct ng_png_params){.width = 2,
                                                                .height = alpha ? 2 : 1,
                                                                .channels = alpha ? 4 : 3,
                                                                .pixels = pixels}),
                     NG_OK);
}

static void load_materials(struct loaded *l, const char *mtl, const char *use, const char *warning)
{
    char text[512];
    put_file("my lib.mtl", mtl, strlen(mtl), NULL);
    snprintf(text, sizeof text, "mtllib my lib.mtl\n" TRIANGLE "vt 0 0\nusemtl %s\nf 1/1 2/1 3/1\n", use);
    load_warned(l, text, warning);
}

static void test_materials(void **state)
{
    NG_UNUSED(state);
    struct loaded l;
    load_materials(&l,
                   "\xef\xbb\xbfnewmtl  unused\nKd 0 0 1\n\nnewmtl  red paint \r\nKd 1 0 0\nKs 0.5 0.5 "
                   "0.5\nNs 30\nillum 2\n",
                   "red paint", NULL);
    const struct ng_material *m = material_of(&l, "red paint");
    assert_int_equal(l.scene.material_count, 1);
    assert_true(m->base_color[0] == 1 && m->base_color[1] == 0 && m->metallic == 0);
    assert_true(fabsf(m->roughness - 0.5f) < 1e-6f); // (2 / 32)^(1/4)
    assert_true(m->double_sided);
    finish(&l);
    load_materials(&l, "newmtl a\nKd 0.5 0.5 0.5\nKe 3 1.5 0\nPr 0.25\nPm 1\n", "a", NULL);
    m = material_of(&l, "a");
    assert_true(fabsf(m->base_color[0] - 0.2140411f) < 1e-5f); // of sRGB
    assert_true(m->roughness == 0.25f && m->metallic == 1);
    assert_true(m->emissive[0] == 1 && m->emissive[1] == 0.5f && m->emissive_strength == 3);
    assert_int_equal(l.scene.light_count, 1);
    finish(&l);
    load_materials(&l, "newmtl a\nKd nan 1e99 -3\nNs inf\nKe nan -1 0\n", "a", NULL);
    m = material_of(&l, "a");
    assert_true(m->base_color[0] == 0 && m->base_color[2] == 0);
    finish(&l);
}

static void test_textures(void **state)
{
    NG_UNUSED(state);
    struct loaded l;
    put_picture("paint 1.png", false);
    put_picture("leaf%.png", true);
    load_materials(&l, "newmtl a\nKd 1 1 1\nmap_Kd .\\paint 1.png\n", "a", NULL);
    assert_true(material_of(&l, "a")->base_color_texture.id != 0);
    assert_int_equal(material_of(&l, "a")->alpha_mode, NG_ALPHA_OPAQUE);
    finish(&l);
    // Of a path of another machine the file's name; what is transparent cuts holes.
    load_materials(&l, "newmtl a\nKd 1 1 1\nmap_Kd C:\\models\\leaf%.png\n", "a", NULL);
    assert_int_equal(material_of(&l, "a")->alpha_mode, NG_ALPHA_MASK);
    finish(&l);
    load_materials(&l, "newmtl a\nKd 1 1 1\nmap_Kd -s 2 4 1 -o 0.5 0.25 0 paint 1.png\n", "a", NULL);
    ng_entity e = l.scene.root;
    while (!ng_world_has(l.world, e, NG_MESH))
        e = ng_world_next_below(l.world, l.scene.root, e);
    assert_true(geometry_of(&l, e)->uvs[0] == 0.5f && geometry_of(&l, e)->uvs[1] == 0.75f);
    finish(&l);
}

// The first texture coordinates, which -s and -o move.
static void check_uv(const char *map, float u, float v, const char *warning)
{
    struct loaded l;
    char mtl[256];
    snprintf(mtl, sizeof mtl, "newmtl a\nKd 1 1 1\n%s\n", map);
    load_materials(&l, mtl, "a", warning);
    if (!material_of(&l, "a")->base_color_texture.id)
        fail_msg("\"%s\" has no texture", map);
    ng_entity e = l.scene.root;
    while (!ng_world_has(l.world, e, NG_MESH))
        e = ng_world_next_below(l.world, l.scene.root, e);
    const float *uv = geometry_of(&l, e)->uvs;
    if (uv[0] != u || uv[1] != v)
        fail_msg("\"%s\": %g %g where %g %g was expected", map, (double)uv[0], (double)uv[1], (double)u,
                 (double)v);
    finish(&l);
}

// Options may have fewer numbers than they could, and stand in any order; names are as programs write them.
static void test_map_options(void **state)
{
    NG_UNUSED(state);
    put_picture("paint 1.png", false);
    put_picture("2.png", false);
    put_picture("-o.png", false);
    char folder[256];
    test_path(folder, sizeof folder, "sub");
    assert_int_equal(ng_file_make_directory(folder), NG_OK);
    put_picture("sub/deep.png", false);
    check_uv("map_Kd -s 2 paint 1.png", 0, 1, NULL);
    check_uv("map_Kd -o 0.5 paint 1.png", 0.5f, 1, NULL);
    check_uv("map_Kd -o 0.5 0.25 paint 1.png", 0.5f, 0.75f, NULL);
    check_uv("map_Kd -o 0.5 0.25 0 -s 2 2.png", 0.5f, 0.75f, NULL);
    check_uv("map_Kd -s 2 -o 0.5 2.png", 0.5f, 1, NULL);
    check_uv(
        "map_Kd -o .5 -bm 1 -clamp on -blendu off -blendv off -texres 512 -imfchan m -cc on -type sphere "
        "paint 1.png",
        0.5f, 1, NULL);
    check_uv("MAP_KD\t-O 0.5\t\"paint 1.png\"  \r", 0.5f, 1, NULL);
    check_uv("map_kd 'paint 1.png'", 0, 1, NULL);
    check_uv("map_Kd -mm 0 1 2.png", 0, 1, NULL);
    check_uv("map_Kd -mm 0.2 2.png", 0, 1, "has -mm of map_Kd");
    check_uv("map_Kd -t 1 2.png", 0, 1, "has -t of map_Kd");
    check_uv("map_Kd -o.png", 0, 1, NULL);
    check_uv("map_Kd .\\sub\\deep.png", 0, 1, NULL);
    check_uv("map_Kd \"sub/deep.png\"", 0, 1, NULL);
}

static void test_libraries(void **state)
{
    NG_UNUSED(state);
    static const char *const lines[] = {"mtllib one.mtl two 2.MTL", "mtllib \"one.mtl\"  \"two 2.MTL\"\r",
                                        "mtllib one.mtl\nmtllib .\\two 2.MTL", "mtllib\tone.mtl\ttwo 2.MTL"};
    put_file("one.mtl", "newmtl a\nKd 1 0 0\n", 18, NULL);
    put_file("two 2.MTL", "newmtl b\r\nKd 0 0 1\r\n", 20, NULL);
    for (size_t i = 0; i < NG_COUNT(lines); i++) {
        struct loaded l;
        char text[256];
        snprintf(text, sizeof text, "%s\n" TRIANGLE "usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n", lines[i]);
        load_warned(&l, text, NULL);
        assert_true(material_of(&l, "a")->base_color[0] == 1);
        assert_true(material_of(&l, "b")->base_color[2] == 1);
        finish(&l);
    }
}

// More than the library is given at a time.
static void test_many_materials(void **state)
{
    NG_UNUSED(state);
    enum { COUNT = 1000 };
    struct loaded l;
    char *text = malloc(COUNT * 64), *at = text;
    assert_non_null(text);
    for (int i = 0; i < COUNT; i++)
        at += sprintf(at, "newmtl m%d\r\nPr %g\r\nKd 1 1 1\r\n", i, (double)(i + 1) / COUNT);
    put_file("many.mtl", text, (size_t)(at - text), NULL);
    at = text + sprintf(text, "mtllib many.mtl\n" TRIANGLE);
    for (int i = 0; i < COUNT; i += 111)
        at += sprintf(at, "usemtl m%d\nf 1 2 3\n", i);
    load_warned(&l, text, NULL);
    for (int i = 0; i < COUNT; i += 111) {
        char name[16];
        snprintf(name, sizeof name, "m%d", i);
        assert_float_equal(material_of(&l, name)->roughness, (float)(i + 1) / COUNT, 1e-6);
    }
    free(text);
    finish(&l);
}

static const unsigned char *texel_of(const struct loaded *l, ng_asset image, uint32_t x, uint32_t y)
{
    const struct ng_image *i = ng_assets_image(l->assets, image);
    assert_non_null(i);
    return (const unsigned char *)i->pixels + (y * i->width + x) * 4;
}

// A slope of heights that grows to the right and down; a normal map stays as it is.
static void test_bumps(void **state)
{
    NG_UNUSED(state);
    enum { SIDE = 16 };
    struct loaded l;
    char path[256];
    unsigned char heights[SIDE * SIDE * 3], normals[SIDE * SIDE * 3];
    for (int i = 0; i < SIDE * SIDE; i++) {
        memset(heights + i * 3, i % SIDE * 8 + i / SIDE * 2, 3);
        memcpy(normals + i * 3, (const unsigned char[]){120, 140, 250}, 3);
    }
    const struct ng_png_params picture = {.width = SIDE, .height = SIDE, .channels = 3};
    struct ng_png_params p = picture;
    p.pixels = heights;
    test_path(path, sizeof path, "heights.png");
    assert_int_equal(ng_png_write(path, &p), NG_OK);
    p.pixels = normals;
    test_path(path, sizeof path, "normals.png");
    assert_int_equal(ng_png_write(path, &p), NG_OK);
    load_materials(&l, "newmtl a\nmap_Bump -bm 0.5 heights.png\n", "a", NULL);
    const unsigned char *n = texel_of(&l, material_of(&l, "a")->normal_texture, 8, 8);
    assert_true(n[0] < 120 && n[1] > 128 && n[1] < 140 && n[2] > 240); // against the slope, green up
    assert_true(material_of(&l, "a")->normal_scale == 0.5f);
    finish(&l);
    load_materials(&l, "newmtl a\nbump normals.png\n", "a", NULL);
    n = texel_of(&l, material_of(&l, "a")->normal_texture, 8, 8);
    assert_memory_equal(n, normals, 3);
    finish(&l);
    load_materials(&l, "newmtl a\nmap_Kd heights.png\nnorm heights.png\n", "a", NULL);
    n = texel_of(&l, material_of(&l, "a")->normal_texture, 8, 8);
    assert_int_equal(n[0], n[2]); // it says that it is one
    finish(&l);
}

// Each costs one warning, however often it is there; the rest is loaded.
static void test_faults(void **state)
{
    NG_UNUSED(state);
    static const struct {
        const char *text, *warning;
        unsigned triangles;
    } cases[] = {
        {"mtllib none.mtl\n" TRIANGLE "usemtl a\nf 1 2 3\n", "none.mtl: cannot open", 1},
        {"mtllib ../a.mtl\n" TRIANGLE "f 1 2 3\n", "is not a file in the document's directory", 1},
        {TRIANGLE "f 1 2 3\nf 1 2 9\nf 1 2 -9\nf 0 1 2\nf 1 2 x\nf 1 2 2147483648\n", "a face names a vertex",
         1},
        {TRIANGLE "vn 0 0 1\nf 1//1 2//7 3//-8\n", "a face names a normal", 1},
        {TRIANGLE "vt 0 0\nf 1/1 2/7 3/-8\n", "a face names texture coordinates", 1},
        {TRIANGLE "v 1e999 0 0\nf 1 2 3\nf 1 2 4\n", "not a finite number", 1},
        {TRIANGLE "vt 1e999 0\nf 1/1 2/1 3/1\n", "a texture coordinate is not a finite number", 1},
        {TRIANGLE "f 1 2 3\nf 1 2\nf 1\n", "a face has 2 corners", 1},
        {TRIANGLE "p 1\nl 1 2\nl 2 3\nf 1 2 3\n", "has points, lines or curves", 1},
        {TRIANGLE "f 1 2 3\nf 1 2 2\nf 1 1 1 1\n", NULL, 1}, // without area: not seen
        {TRIANGLE "f 1 2 3\nt crease 8192/8192/8192\nvw 0 0 1\nxyz\n\xff\xfe\n", NULL, 1},
        {TRIANGLE "usemtl a\nf 1 2 3\n", NULL, 1}, // it names no library
    };
    for (size_t i = 0; i < NG_COUNT(cases); i++) {
        struct loaded l;
        load_warned(&l, cases[i].text, cases[i].warning);
        assert_int_equal(l.scene.triangle_count, cases[i].triangles);
        finish(&l);
        bool strict = load_params(&l, cases[i].text, &(struct ng_gltf_params){.strict = true}) == NG_OK;
        assert_int_equal(strict, cases[i].warning == NULL);
        finish(&l);
    }
}

static void test_texture_faults(void **state)
{
    NG_UNUSED(state);
    struct loaded l;
    put_file("damaged.png", "\x89PNG\r\n\x1a\n", 8, NULL);
    put_picture("paint 1.png", false);
    load_materials(&l, "newmtl a\nmap_Kd gone.png\nmap_Ke gone.png\n", "a", "gone.png: cannot open");
    finish(&l);
    load_materials(&l, "newmtl a\nmap_Kd /etc/../../x/../passwd\n", "a", "passwd: cannot open");
    finish(&l);
    load_materials(&l, "newmtl a\nmap_Kd sub/../../scene.obj\n", "a",
                   "is not a file in the document's directory");
    finish(&l);
    load_materials(&l, "newmtl a\nmap_Kd damaged.png\n", "a", "image 0");
    finish(&l);
    load_materials(&l, "newmtl a\nmap_Ks paint 1.png\n", "a", "has map_Ks");
    finish(&l);
    load_materials(&l, "newmtl b\n", "a", "material \"a\" is in no MTL file");
    finish(&l);
}

static void test_refused(void **state)
{
    NG_UNUSED(state);
    refused("v 0 0 0\n", 8, NG_ERROR_FORMAT, "is an OBJ file without faces");
    refused("# nothing\n", 10, NG_ERROR_FORMAT, "is not a glTF file, nor OBJ");
    refused("\0v 0 0 0", 8, NG_ERROR_FORMAT, "is not a glTF file, nor OBJ");
    refused("vertex 1 2 3\n", 13, NG_ERROR_FORMAT, "is not a glTF file, nor OBJ");
    struct loaded l;
    assert_int_equal(load_params(&l, TRIANGLE "f 1 2 9\n", NULL), NG_ERROR_FORMAT);
    assert_non_null(strstr(l.log.text, "no face can be drawn"));
    assert_int_equal(l.log.errors, 1);
    finish(&l);
}

// A file of a cube, cut at every byte.
static void test_cut(void **state)
{
    NG_UNUSED(state);
    static const char cube[] =
        "mtllib my lib.mtl\no cube\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\n"
        "vt 0 0\nvn 0 0 1\ns 1\nusemtl a\nf 4/1/1 3/1/1 2/1/1 1/1/1\ng side\nf -6 -5 -1 -2\n";
    for (size_t size = 1; size < sizeof cube; size++) {
        struct loaded l;
        char path[256];
        put_file("cut.obj", cube, size - 1, path);
        ng_result r = load_path(&l, path, NULL);
        assert_int_equal(l.log.errors, r != NG_OK);
        finish(&l);
    }
}

static void test_limits(void **state)
{
    NG_UNUSED(state);
    struct loaded l;
    assert_int_equal(load_params(&l, TRIANGLE "f 1 2 3\n", &(struct ng_gltf_params){.max_memory = 64}),
                     NG_ERROR_MEMORY);
    assert_int_equal(l.log.errors, 1);
    finish(&l);
    assert_int_equal(load_params(&l, TRIANGLE "f 1 2 3\n", &(struct ng_gltf_params){.max_file_size = 8}),
                     NG_ERROR_MEMORY);
    finish(&l);
    // A polygon that crosses itself everywhere ends soon.
    enum { CORNERS = 20000 };
    char *text = malloc(CORNERS * 64), *at = text;
    assert_non_null(text);
    for (int i = 0; i < CORNERS; i++)
        at += sprintf(at, "v %d %d 0\n", i * 7919 % CORNERS, i * 104729 % 20011);
    at += sprintf(at, "f");
    for (int i = 1; i <= CORNERS; i++)
        at += sprintf(at, " %d", i);
    load(&l, text);
    assert_int_equal(l.scene.triangle_count, CORNERS - 2);
    finish(&l);
    // One without area, too.
    at = text + sprintf(text, TRIANGLE "f");
    for (int i = 0; i < CORNERS / 4; i++)
        at += sprintf(at, " %d", i % 3 + 1);
    load(&l, text);
    free(text);
    finish(&l);
}

static void note_file(void *user, const char *path)
{
    const char *name = strrchr(path, '/');
    memcpy((char *)user + strlen(user), name, strlen(name) + 1);
}

// Whoever writes pictures is told of each file that is read; equal files are equal scenes.
static void test_files(void **state)
{
    NG_UNUSED(state);
    struct loaded a, b;
    char files[512] = "";
    put_picture("paint 1.png", false);
    load_materials(&a, "newmtl a\nmap_Kd paint 1.png\n", "a", NULL);
    char path[256];
    test_path(path, sizeof path, "scene.obj");
    assert_int_equal(load_path(&b, path, &(struct ng_gltf_params){.file = note_file, .user = files}), NG_OK);
    assert_string_equal(files, "/my lib.mtl/paint 1.png");
    assert_true(a.scene.hash == b.scene.hash);
    finish(&b);
    load_materials(&b, "newmtl a\nKd 1 0 0\n", "a", NULL);
    assert_true(a.scene.hash != b.scene.hash);
    finish(&a);
    finish(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parts),          cmocka_unit_test(test_attributes),
        cmocka_unit_test(test_lines),          cmocka_unit_test(test_made_normals),
        cmocka_unit_test(test_bad_normals),    cmocka_unit_test(test_polygons),
        cmocka_unit_test(test_materials),      cmocka_unit_test(test_textures),
        cmocka_unit_test(test_map_options),    cmocka_unit_test(test_libraries),
        cmocka_unit_test(test_many_materials), cmocka_unit_test(test_bumps),
        cmocka_unit_test(test_faults),         cmocka_unit_test(test_texture_faults),
        cmocka_unit_test(test_refused),        cmocka_unit_test(test_cut),
        cmocka_unit_test(test_limits),         cmocka_unit_test(test_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
