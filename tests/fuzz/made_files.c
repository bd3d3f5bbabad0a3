#include "made_files.h"

#include "test.h"

#include "asset/exr.h"
#include "base/file.h"
#include "lightformer/dataset/manifest.h"
#include "lightformer/reference/reference_internal.h"

#include <zip.h>

void made_properties(const char *path)
{
    static const char text[] =
        "name=Things\nlicense=CC-BY \\u00e9\nid#1=T#box\nname#1=A box\nmodel#1=/m/box.obj\n"
        "width#1=100\ndepth#1=50.5\nheight#1=20\nmodelRotation#1=0 0 1 0 1 0 -1 0 0\n"
        "creator#1=\\\n  Ann\nmovable#1=true\n";
    assert_int_equal(ng_file_write(path, text, sizeof text - 1), NG_OK);
}

static void pack(zip_t *zip, const char *name, const void *data, size_t size)
{
    zip_source_t *source = zip_source_buffer(zip, data, size, 0);
    assert_true(source && zip_file_add(zip, name, source, 0) >= 0);
}

void made_catalogue(const char *path, const void *properties, size_t size)
{
    static const char box[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n";
    zip_t *zip = zip_open(path, ZIP_CREATE | ZIP_TRUNCATE, NULL);
    assert_non_null(zip);
    pack(zip, "PluginFurnitureCatalog.properties", properties, size);
    pack(zip, "m/box.obj", box, sizeof box - 1);
    assert_int_equal(zip_close(zip), 0);
}

void made_exr(const char *path)
{
    float pixels[20 * 8 * 4];
    uint32_t ids[20 * 8];
    for (uint32_t i = 0; i < NG_COUNT(pixels); i++)
        pixels[i] = (float)i;
    for (uint32_t i = 0; i < NG_COUNT(ids); i++)
        ids[i] = i;
    struct ng_exr_channel channels[] = {{"R", NG_EXR_HALF, pixels, 4},
                                        {"G", NG_EXR_HALF, pixels + 1, 4},
                                        {"B", NG_EXR_FLOAT, pixels + 2, 4},
                                        {"entity.id", NG_EXR_UINT, ids, 1}};
    struct ng_exr_text text = {"command", "lightformer render"};
    struct ng_exr_params params = {.width = 20,
                                   .height = 8,
                                   .channels = channels,
                                   .channel_count = NG_COUNT(channels),
                                   .texts = &text,
                                   .text_count = 1};
    assert_int_equal(ng_exr_write(path, &params), NG_OK);
}

static struct lf_reference *make_reference(void)
{
    struct lf_reference *reference;
    struct lf_reference_params params = {.width = 3, .height = 2};
    assert_int_equal(lf_reference_create(&params, &reference), NG_OK);
    return reference;
}

void made_checkpoint(const char *path)
{
    struct lf_reference *reference = make_reference();
    assert_int_equal(lf_checkpoint_write(reference, path, 7), NG_OK);
    lf_reference_destroy(&reference);
}

ng_result made_checkpoint_read(const char *path)
{
    struct lf_reference *reference = make_reference();
    ng_result r = lf_checkpoint_read(reference, path, 7);
    lf_reference_destroy(&reference);
    return r;
}

void made_manifest(const char *path)
{
    char folder[512];
    struct lf_manifest m = {0};
    for (int i = 0; i < LF_SETTING_COUNT; i++) {
        snprintf(m.settings.items[i].key, sizeof m.settings.items[i].key, "key%d", i);
        snprintf(m.settings.items[i].value, sizeof m.settings.items[i].value, "value %d", i);
    }
    for (uint32_t i = 0; i < 3; i++)
        assert_int_equal(lf_manifest_put(&m, &(struct lf_shard){i * 4, i, 4}), NG_OK);
    snprintf(folder, sizeof folder, "%.*s", (int)(ng_path_name(path) - path), path);
    assert_int_equal(lf_manifest_write(folder, &m), NG_OK);
    lf_manifest_finish(&m);
}
