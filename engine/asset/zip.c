// Files within a zip in memory, by libzip. Nothing is unpacked to disk, and names only look up what is there.
#include "asset/catalogue_internal.h"
#include "base/log.h"

#include <zip.h>

#include <stdlib.h>
#include <string.h>

// Texts pack to a tenth at best, zeros to a thousandth: what grows more than this is no model.
#define MOST_GROWTH 100
#define SMALL_FILE  (32u << 20)

struct ng_zip {
    zip_t *handle;
    char *path;
};

bool ng_is_zip(const void *data, size_t size)
{
    return size >= 4 && (memcmp(data, "PK\3\4", 4) == 0 || memcmp(data, "PK\5\6", 4) == 0);
}

static zip_t *open_bytes(const char *path, void *data, size_t size)
{
    zip_error_t error;
    zip_error_init(&error);
    zip_source_t *source = zip_source_buffer_create(data, size, 1, &error);
    zip_t *handle = source ? zip_open_from_source(source, ZIP_RDONLY, &error) : NULL;
    if (!handle)
        ng_log_error("%s: is a damaged zip file: %s", path, zip_error_strerror(&error));
    if (source && !handle)
        zip_source_free(source);
    if (!source)
        free(data);
    zip_error_fini(&error);
    return handle;
}

ng_result ng_zip_open(const char *path, void *data, size_t size, struct ng_zip **out)
{
    struct ng_zip *zip = calloc(1, sizeof *zip);
    *out = NULL;
    if (!zip) {
        free(data);
        return ng_out_of_memory(path);
    }
    if (size) {
        zip->handle = open_bytes(path, data, size);
    } else { // libzip would not take the bytes of nothing
        ng_log_error("%s: is an empty file, not a zip file", path);
        free(data);
    }
    size_t length = strlen(path) + 1;
    zip->path = malloc(length);
    if (zip->handle && zip->path) {
        memcpy(zip->path, path, length);
        *out = zip;
        return NG_OK;
    }
    ng_result r = zip->handle ? ng_out_of_memory(path) : NG_ERROR_FORMAT;
    ng_zip_close(&zip);
    return r;
}

void ng_zip_close(struct ng_zip **zip)
{
    if (!*zip)
        return;
    if ((*zip)->handle)
        zip_discard((*zip)->handle);
    free((*zip)->path);
    free(*zip);
    *zip = NULL;
}

static ng_result find_file(struct ng_zip *zip, const char *name, uint64_t limit, zip_stat_t *stat)
{
    // Names that differ in case alone: models are made on systems that do not mind.
    zip_int64_t index = zip_name_locate(zip->handle, name, 0);
    if (index < 0)
        index = zip_name_locate(zip->handle, name, ZIP_FL_NOCASE);
    if (index < 0 || zip_stat_index(zip->handle, (zip_uint64_t)index, 0, stat) != 0) {
        ng_log_error("%s: has no file %s", zip->path, name);
        return NG_ERROR_NOT_FOUND;
    }
    if (!(stat->valid & ZIP_STAT_SIZE) || !(stat->valid & ZIP_STAT_COMP_SIZE) || stat->size > limit) {
        ng_log_error("%s: %s: is larger than the %llu bytes that may be read" NG_GLTF_RAISE, zip->path, name,
                     (unsigned long long)limit);
        return NG_ERROR_MEMORY;
    }
    if (stat->size > SMALL_FILE && stat->size / MOST_GROWTH > stat->comp_size) {
        ng_log_error("%s: %s: says that %llu bytes are packed into %llu; that is no model", zip->path, name,
                     (unsigned long long)stat->size, (unsigned long long)stat->comp_size);
        return NG_ERROR_FORMAT;
    }
    return NG_OK;
}

// The checksum is compared where the end is met, so one byte more is asked for than is there.
static ng_result read_file(struct ng_zip *zip, const char *name, const zip_stat_t *stat, char *out)
{
    zip_file_t *file = zip_fopen_index(zip->handle, stat->index, 0);
    zip_int64_t got = -1, rest = 0;
    if (file)
        got = zip_fread(file, out, stat->size);
    if (file && got == (zip_int64_t)stat->size)
        rest = zip_fread(file, out + stat->size, 1);
    bool whole = file && got == (zip_int64_t)stat->size && rest == 0;
    if (!whole)
        ng_log_error("%s: %s: cannot be unpacked: %s", zip->path, name,
                     !file                 ? zip_strerror(zip->handle)
                     : got < 0 || rest < 0 ? zip_file_strerror(file)
                                           : "its size is not what the zip says");
    if (file)
        zip_fclose(file);
    return whole ? NG_OK : NG_ERROR_FORMAT;
}

ng_result ng_zip_read(struct ng_zip *zip, const char *name, uint64_t limit, void **data, size_t *size)
{
    zip_stat_t stat;
    *data = NULL;
    NG_TRY(find_file(zip, name, limit, &stat));
    char *out = malloc((size_t)stat.size + 1);
    if (!out)
        return ng_out_of_memory(zip->path);
    ng_result r = read_file(zip, name, &stat, out);
    if (r != NG_OK) {
        free(out);
        return r;
    }
    out[stat.size] = 0;
    *data = out;
    *size = (size_t)stat.size;
    return NG_OK;
}
