// A loop over shards: one that is whole is kept, any other is made; after each the manifest is written. A
// kill at any moment leaves whole shards and a manifest that lists some of them.
#include "lightformer/dataset/dataset.h"

#include "base/file.h"
#include "base/log.h"
#include "base/system.h"
#include "lightformer/dataset/manifest.h"
#include "lightformer/dataset/sampler.h"
#include "lightformer/net/net.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

struct run {
    struct lf_dataset_params p; // with crop and crops as they are meant
    struct lf_dataset_report *report;
    struct lf_scene_sampler *sampler;
    struct lf_capture *observer;
    struct lf_sample_writer *writer;
    struct lf_manifest manifest;
    struct lf_manifest targets; // of the data set whose targets are taken
    uint32_t per_shard, done;   // samples
    bool made_folder;
};

// ---- settings --------------------------------------------------------------------------------------------

static ng_result refuse(const char *reason)
{
    ng_log_error("dataset: %s", reason);
    return NG_ERROR_FORMAT;
}

static ng_result check_params(const struct lf_dataset_params *p)
{
    if (!p->count)
        return refuse("a data set has at least one sample");
    if (!p->spp)
        return refuse("0 samples a pixel give no targets; spp is at least 1");
    if (!p->size || p->size > LF_DATASET_MAX_SIZE)
        return refuse("frames have 1 to 4096 pixels a side");
    if (p->crop > p->size)
        return refuse("crops are larger than the frame");
    if (!p->crops || !p->shard)
        return refuse("crops of a frame and of a shard are at least 1");
    if (p->seed > UINT32_MAX || p->count - 1 > UINT32_MAX - p->seed)
        return refuse("seeds go up to 4294967295, the last sample's too");
    return NG_OK;
}

// Control characters of a name have no place in a header: they become dashes.
static void put_word(struct lf_setting *note, const char *key, const char *value)
{
    snprintf(note->key, sizeof note->key, "%s", key);
    snprintf(note->value, sizeof note->value, "%s", value);
    for (char *c = note->value; *c; c++)
        if ((unsigned char)*c < 0x20)
            *c = '-';
}

static void make_settings(const struct lf_dataset_params *p, struct lf_settings *s)
{
    const struct {
        const char *key;
        uint32_t value;
    } numbers[] = {
        {"size", p->size}, {"crop", p->crop},   {"crops", p->crops},
        {"spp", p->spp},   {"depth", p->depth}, {"vpls", p->vpls},
    };
    struct lf_setting *note = s->items;
    char word[32];
    put_word(note++, "format", LF_INPUTS_VERSION);
    put_word(note++, "program", p->program);
    put_word(note++, "scene", p->scene);
    snprintf(word, sizeof word, "%016" PRIx64, p->scene_hash);
    put_word(note++, "scene_hash", word);
    for (size_t i = 0; i < NG_COUNT(numbers); i++) {
        snprintf(word, sizeof word, "%u", numbers[i].value);
        put_word(note++, numbers[i].key, word);
    }
    put_word(note++, "camera", p->camera ? p->camera : "");
    snprintf(word, sizeof word, "%.9g", p->time);
    put_word(note, "time", word);
}

// Runs that were killed while they wrote leave "SHARD.tmp-RANDOM". Those of shards of this range are nobody
// else's: no two runs make the same seeds.
static void remove_leftover(void *user, const char *name)
{
    const struct run *run = user;
    struct lf_shard shard;
    char path[4096];
    const char *rest = lf_shard_of_name(name, &shard);
    if (!rest || strncmp(rest, ".tmp-", 5) != 0 || shard.first_seed < run->p.seed ||
        shard.first_seed + shard.samples > run->p.seed + run->p.count)
        return;
    int n = snprintf(path, sizeof path, "%s/%s", run->p.directory, name);
    if (n > 0 && (size_t)n < sizeof path)
        remove(path);
}

// The shard of this range that holds a seed: shards are cut at multiples.
static struct lf_shard shard_at(const struct run *run, uint64_t seed)
{
    uint64_t end = run->p.seed + run->p.count, first = seed - seed % run->per_shard,
             next = first + run->per_shard;
    first = first > run->p.seed ? first : run->p.seed;
    next = next < end ? next : end;
    return (struct lf_shard){.first_seed = first, .samples = (uint32_t)(next - first)};
}

// A shard takes the place of those that it overlaps, which must not hold what it has not.
static ng_result check_cuts(const struct run *run)
{
    uint64_t end = run->p.seed + run->p.count;
    for (size_t i = 0; i < run->manifest.shards.count; i++) {
        const struct lf_shard *old = &run->manifest.shards.items[i];
        uint64_t old_end = old->first_seed + old->samples;
        if (old_end <= run->p.seed || old->first_seed >= end)
            continue;
        struct lf_shard by = shard_at(run, old->first_seed > run->p.seed ? old->first_seed : run->p.seed);
        if (by.first_seed <= old->first_seed && old_end <= by.first_seed + by.samples)
            continue;
        ng_log_error("%s: seeds %" PRIu64 " to %" PRIu64
                     " are one shard there, which other ranges would cut; "
                     "ask for all of them, with the same --shard, or choose another folder",
                     run->p.directory, old->first_seed, old_end - 1);
        return NG_ERROR_FORMAT;
    }
    return NG_OK;
}

// A folder holds one data set: its manifest has to have these settings.
static ng_result open_manifest(struct run *run)
{
    struct lf_settings settings = {0};
    make_settings(&run->p, &settings);
    run->made_folder = !ng_file_exists(run->p.directory);
    NG_TRY(ng_file_make_directory(run->p.directory));
    ng_result found = lf_manifest_read(run->p.directory, &run->manifest);
    if (found == NG_ERROR_NOT_FOUND) {
        run->manifest.settings = settings;
        return ng_file_list(run->p.directory, remove_leftover, run);
    }
    NG_TRY(found);
    const struct lf_setting *other = lf_settings_difference(&run->manifest.settings, &settings);
    if (!other) {
        NG_TRY(check_cuts(run));
        return ng_file_list(run->p.directory, remove_leftover, run);
    }
    ng_log_error("%s: holds a data set with other settings (%s is \"%s\" there); choose another folder",
                 run->p.directory, other->key, other->value);
    return NG_ERROR_FORMAT;
}

// What is traced has to be the same; inputs may not be.
static ng_result open_targets(struct run *run)
{
    if (!run->p.targets)
        return NG_OK;
    ng_result found = lf_manifest_read(run->p.targets, &run->targets);
    if (found == NG_ERROR_NOT_FOUND)
        ng_log_error("%s: no data set to take targets from (there is no manifest.json)", run->p.targets);
    NG_TRY(found);
    struct lf_settings like = run->manifest.settings;
    for (int i = 0; i < LF_SETTING_COUNT; i++)
        if (strcmp(like.items[i].key, "format") == 0 || strcmp(like.items[i].key, "program") == 0)
            like.items[i] = run->targets.settings.items[i];
    const struct lf_setting *other = lf_settings_difference(&run->targets.settings, &like);
    if (!other)
        return NG_OK;
    ng_log_error("%s: its targets are of other settings (%s is \"%s\" there)", run->p.targets, other->key,
                 other->value);
    return NG_ERROR_FORMAT;
}

// ---- shards ----------------------------------------------------------------------------------------------

static struct lf_sample_params sample_params(const struct run *run)
{
    return (struct lf_sample_params){.size = run->p.size,
                                     .crop = run->p.crop,
                                     .crops = run->p.crops,
                                     .spp = run->p.spp,
                                     .vpls = run->p.vpls,
                                     .depth = run->p.depth,
                                     .jobs = run->p.jobs};
}

// Samples of the largest shard of the range.
static uint32_t largest_shard(const struct run *run)
{
    uint32_t first = run->per_shard - (uint32_t)(run->p.seed % run->per_shard);
    if (run->p.count <= first)
        return run->p.count;
    uint32_t rest = run->p.count - first < run->per_shard ? run->p.count - first : run->per_shard;
    return first > rest ? first : rest;
}

// Refuses shards that will not fit, before hours of work: such that a file cannot hold, or memory, where a
// shard lies twice while it is written.
static ng_result check_memory(const struct run *run, double sample_bytes)
{
    double bytes = sample_bytes * largest_shard(run), available = (double)ng_system_available_memory() / 2;
    bool fits_file = bytes <= (double)LF_TENSOR_LIMIT;
    if (fits_file && bytes <= available)
        return NG_OK;
    ng_log_error("dataset: a shard of %u samples takes %.0f MiB, of which %s %.0f MiB; make shards or crops "
                 "smaller (--shard, --crops, --crop)",
                 largest_shard(run), bytes / (1 << 20), fits_file ? "memory has room for" : "a file holds",
                 (fits_file ? available : (double)LF_TENSOR_LIMIT) / (1 << 20));
    return NG_ERROR_MEMORY;
}

static ng_result make_sample(struct run *run, uint64_t seed, const struct lf_tensors *targets,
                             struct lf_tensors *out)
{
    struct lf_sample_params params = sample_params(run);
    double *spent = run->report->spent;
    struct lf_sample sample;
    struct lf_captured_frame observation;
    params.targets = targets;
    uint64_t begin = ng_clock_ns();
    NG_TRY(lf_scene_sampler_begin(run->sampler, seed, &sample));
    uint64_t varied = ng_clock_ns();
    ng_result result = lf_capture_frame(
        run->observer,
        &(struct lf_capture_params){
            .snapshot = sample.snapshot, .width = run->p.size, .height = run->p.size, .pixels_only = true},
        &observation);
    uint64_t observed = ng_clock_ns();
    spent[LF_STAGE_VARY] += (double)(varied - begin) * 1e-9;
    spent[LF_STAGE_CAPTURE] += (double)(observed - varied) * 1e-9;
    if (result == NG_OK)
        result = lf_sample_write(run->writer, &sample, &observation, &params, out, spent);
    ng_result ended = lf_scene_sampler_end(run->sampler);
    return result != NG_OK ? result : ended;
}

static ng_result add_notes(const struct run *run, const struct lf_shard *shard, struct lf_tensors *out)
{
    char number[32];
    for (int i = 0; i < LF_SETTING_COUNT; i++)
        NG_TRY(
            lf_tensors_note(out, run->manifest.settings.items[i].key, run->manifest.settings.items[i].value));
    snprintf(number, sizeof number, "%" PRIu64, shard->first_seed);
    NG_TRY(lf_tensors_note(out, "first_seed", number));
    snprintf(number, sizeof number, "%u", shard->samples);
    return lf_tensors_note(out, "samples", number);
}

static bool report_progress(struct run *run, uint32_t samples)
{
    run->done += samples;
    return !run->p.progress || run->p.progress(run->p.user, run->done, run->p.count);
}

// The shard of these seeds with targets. True if there is one.
static bool read_targets(const struct run *run, const struct lf_shard *shard, struct lf_tensors *out)
{
    const struct lf_shard *listed = lf_manifest_find(&run->targets, shard);
    const char *wrong = NULL;
    char path[4096];
    *out = (struct lf_tensors){0};
    if (!listed || !lf_shard_path(run->p.targets, listed, path, sizeof path))
        return false;
    if (lf_shard_try(path, &run->targets.settings, listed, out, &wrong) == NG_OK)
        return true;
    ng_log_warn("%s: %s; its targets are traced instead", path, wrong ? wrong : "cannot be read");
    return false;
}

static ng_result fill_shard(struct run *run, const struct lf_shard *shard, const struct lf_tensors *targets,
                            struct lf_tensors *tensors, bool *stopped)
{
    NG_TRY(add_notes(run, shard, tensors));
    for (uint32_t i = 0; i < shard->samples && !*stopped; i++) {
        NG_TRY(make_sample(run, shard->first_seed + i, targets, tensors));
        if (run->report->samples++ == 0) // later ones are about as large
            NG_TRY(check_memory(run, (double)tensors->bytes));
        run->report->crops += run->p.crops;
        *stopped = !report_progress(run, 1);
    }
    return NG_OK;
}

static ng_result make_shard(struct run *run, struct lf_shard *shard, const char *path, bool *stopped)
{
    struct lf_tensors tensors = {0}, targets;
    bool has_targets = read_targets(run, shard, &targets);
    ng_result result = fill_shard(run, shard, has_targets ? &targets : NULL, &tensors, stopped);
    lf_tensors_finish(&targets);
    uint64_t begin = ng_clock_ns();
    if (result == NG_OK && !*stopped)
        result = lf_tensors_write(&tensors, path);
    shard->hash = tensors.hash;
    lf_tensors_finish(&tensors);
    run->report->spent[LF_STAGE_WRITE] += (double)(ng_clock_ns() - begin) * 1e-9;
    return result;
}

// Whether the shard is there, whole. Fails if it is one of another data set: only what is damaged is made
// again.
static ng_result look_for(struct run *run, struct lf_shard *shard, const char *path, bool *whole)
{
    struct lf_tensors tensors;
    const char *wrong;
    *whole = false;
    if (!ng_file_exists(path))
        return NG_OK;
    const struct lf_shard *listed = lf_manifest_find(&run->manifest, shard);
    shard->hash = listed ? listed->hash : 0; // 0: any
    ng_result result = lf_shard_try(path, &run->manifest.settings, shard, &tensors, &wrong);
    if (result == NG_ERROR_UNSUPPORTED) {
        ng_log_error("%s: %s; choose another folder, or remove it", path, wrong);
        return NG_ERROR_FORMAT;
    }
    *whole = result == NG_OK;
    if (*whole) {
        shard->hash = tensors.hash;
        run->report->kept++;
    } else {
        if (wrong)
            ng_log_warn("%s: %s; it is made again", path, wrong);
        run->report->redone++;
    }
    lf_tensors_finish(&tensors);
    return NG_OK;
}

// Files of shards that this one takes the place of: shorter ones, from a run that ended within it.
static void remove_overlapped(const struct run *run, const struct lf_shard *shard)
{
    for (size_t i = 0; i < run->manifest.shards.count; i++) {
        const struct lf_shard *old = &run->manifest.shards.items[i];
        char path[4096];
        bool same = old->first_seed == shard->first_seed && old->samples == shard->samples;
        if (!same && old->first_seed < shard->first_seed + shard->samples &&
            shard->first_seed < old->first_seed + old->samples &&
            lf_shard_path(run->p.directory, old, path, sizeof path))
            remove(path);
    }
}

static ng_result do_shard(struct run *run, struct lf_shard *shard, bool *stopped)
{
    char path[4096];
    if (!lf_shard_path(run->p.directory, shard, path, sizeof path)) {
        ng_log_error("%s: the path is too long", run->p.directory);
        return NG_ERROR_IO;
    }
    bool whole;
    run->report->shards++;
    NG_TRY(look_for(run, shard, path, &whole));
    if (whole)
        *stopped = !report_progress(run, shard->samples);
    else
        NG_TRY(make_shard(run, shard, path, stopped));
    if (shard->hash == 0)
        return NG_OK; // stopped before it was written
    remove_overlapped(run, shard);
    NG_TRY(lf_manifest_put(&run->manifest, shard));
    return lf_manifest_write(run->p.directory, &run->manifest);
}

static ng_result do_shards(struct run *run)
{
    uint64_t seed = run->p.seed, end = seed + run->p.count;
    bool stopped = false;
    while (seed < end && !stopped) {
        struct lf_shard shard = shard_at(run, seed);
        NG_TRY(do_shard(run, &shard, &stopped));
        seed += shard.samples;
    }
    return NG_OK;
}

ng_result lf_dataset_make(const struct lf_dataset_params *params, struct lf_dataset_report *report)
{
    struct run run = {.p = *params, .report = report};
    *report = (struct lf_dataset_report){0};
    NG_TRY(check_params(params));
    if (!run.p.vpls)
        run.p.vpls = LF_VPL_COUNT;
    if (!run.p.crop) {
        run.p.crop = run.p.size;
        run.p.crops = 1;
    }
    run.per_shard = run.p.shard > run.p.crops ? run.p.shard / run.p.crops : 1;
    const struct lf_sample_params sample = sample_params(&run);
    NG_TRY(check_memory(&run, lf_sample_least_bytes(&sample)));
    const struct lf_scene_sampler_params sampler = {.world = run.p.world,
                                                    .assets = run.p.assets,
                                                    .jobs = run.p.jobs,
                                                    .time = run.p.time,
                                                    .camera = run.p.camera};
    uint64_t begin = ng_clock_ns();
    ng_result result = lf_scene_sampler_create(&sampler, &run.sampler);
    if (result == NG_OK)
        result = lf_capture_create(run.p.gpu, run.p.jobs, &run.observer);
    if (result == NG_OK)
        result = lf_sample_writer_create(&run.writer);
    if (result == NG_OK)
        result = open_manifest(&run);
    if (result == NG_OK)
        result = open_targets(&run);
    if (result == NG_OK)
        result = do_shards(&run);
    if (result != NG_OK && run.made_folder)
        remove(run.p.directory); // which succeeds if it is empty
    lf_sample_writer_destroy(&run.writer);
    lf_capture_destroy(&run.observer);
    lf_scene_sampler_destroy(&run.sampler);
    lf_manifest_finish(&run.manifest);
    lf_manifest_finish(&run.targets);
    report->seconds = (double)(ng_clock_ns() - begin) * 1e-9;
    return result;
}

// ---- checking --------------------------------------------------------------------------------------------

// Shards of the folder that the manifest does not list.
struct unlisted {
    const struct lf_manifest *manifest;
    struct lf_shard first; // by seed
    uint32_t count;
};

static void find_unlisted(void *user, const char *name)
{
    struct unlisted *u = user;
    struct lf_shard shard;
    const char *rest = lf_shard_of_name(name, &shard);
    if (!rest || *rest || lf_manifest_find(u->manifest, &shard))
        return;
    if (u->count++ == 0 || shard.first_seed < u->first.first_seed)
        u->first = shard;
}

// Two runs at a time in one folder each write the list that they know.
static ng_result check_listed(const char *directory, const struct lf_manifest *manifest, uint32_t *count)
{
    struct unlisted u = {.manifest = manifest};
    char path[4096];
    NG_TRY(ng_file_list(directory, find_unlisted, &u));
    *count = u.count;
    if (u.count && lf_shard_path(directory, &u.first, path, sizeof path))
        ng_log_warn("%s: is not listed in manifest.json (shards that are not: %u); run the whole range of "
                    "seeds again, which checks and lists what is there",
                    path, u.count);
    return NG_OK;
}

ng_result lf_dataset_check(const char *directory, struct lf_dataset_contents *out)
{
    struct lf_manifest manifest;
    *out = (struct lf_dataset_contents){0};
    ng_result result = lf_manifest_read(directory, &manifest);
    if (result == NG_ERROR_NOT_FOUND)
        ng_log_error("%s: no data set is here (there is no manifest.json)", directory);
    NG_TRY(result);
    for (size_t i = 0; i < manifest.shards.count; i++) {
        struct lf_tensors t;
        out->shards++;
        if (lf_shard_read(directory, &manifest.settings, &manifest.shards.items[i], &t) != NG_OK) {
            out->damaged++;
            continue;
        }
        out->samples += manifest.shards.items[i].samples;
        out->tensors += t.list.count;
        out->bytes += t.bytes;
        lf_tensors_finish(&t);
    }
    result = check_listed(directory, &manifest, &out->unlisted);
    lf_manifest_finish(&manifest);
    return out->damaged ? NG_ERROR_FORMAT : result;
}
