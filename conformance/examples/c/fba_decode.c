/* Rules: SYS-1..7 (face objects), FBA-1..35, 37..42, 44 (arithmetic mode), CNF-1, CNF-7, CNF-21, CNF-22.
 * Not here: the DCT mode, mesh objects (Unsupported), draft start codes, findings.
 *
 * Every function that reads returns false when decoding must stop: at the first fault (d->error is set) or when memory
 * or the callback failed (d->failed). TRY passes that on. */
#include "fba_decode.h"

#include "fba_tables.h"
#include "fba_time.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TRY(done)         \
    do {                  \
        if (!(done))      \
            return false; \
    } while (0)

enum { I_MAX, I_MIN, P_MAX, P_MIN, LISTS }; /* the order of FBA-16 */
enum { VISEME = 3, EXPRESSION = 4, HIGH_LEVEL = VISEME + EXPRESSION, FACE = HIGH_LEVEL + FAPS - 2 };
enum { MAX_SKIP = 1000000, MAX_IDLE = 1024, MAX_FREQUENCY = 16383, GUARD_AFTER = 22, LINE = 1 << 15 };

/* One coded number: a FAP of 3..68, one of the seven symbols of FAP 1 and 2, or a BAP. */
struct channel {
    int32_t limit[LISTS]; /* undivided (FBA-19) */
    int32_t force[LISTS]; /* divided, in quantised values */
    int64_t step, value;
    uint32_t total, room; /* P model: sum, places allocated */
    uint16_t *frequency;
};

struct decoder {
    const uint8_t *data;
    uint64_t bits, pos, ones_end; /* ones_end: behind the last 1 bit */
    fba_write write;
    void *user;
    struct fba_error *error;
    bool failed;

    struct channel face[FACE];
    bool face_seen, selected[FAPS], interpolate[FAPS], decoded[FAPS];
    char state[FAPS + 1];
    uint32_t quant;
    unsigned viseme_def, init_face, expression_def;

    struct channel body[BAPS];
    bool body_seen, body_selected[BAPS];

    uint32_t rate; /* sixteenths of a frame per second */
    bool offset;
    struct fba_time time, shown;
    uint64_t index;
    size_t length;
    char line[LINE];
};

static bool fail(struct decoder *d, const char *error_class, const char *rule, uint64_t first, uint64_t end)
{
    *d->error = (struct fba_error){error_class, rule, first, end};
    return false;
}

static bool give_up(struct decoder *d)
{
    d->failed = true;
    return false;
}

/* ---- raw bits ---- */

static uint32_t peek(const struct decoder *d, uint64_t pos, unsigned count)
{
    uint32_t value = 0;
    for (uint64_t i = pos; i < pos + count; i++)
        value = value << 1 | (d->data[i / 8] >> (7 - i % 8) & 1u);
    return value;
}

static bool has(const struct decoder *d, uint64_t pos, unsigned count)
{
    return pos <= d->bits && d->bits - pos >= count;
}

static bool u(struct decoder *d, unsigned count, const char *rule, uint32_t *value)
{
    if (!has(d, d->pos, count))
        return fail(d, "Truncated", rule, d->pos, d->bits);
    *value = peek(d, d->pos, count);
    d->pos += count;
    return true;
}

static bool marker(struct decoder *d, const char *rule)
{
    uint32_t bit;
    TRY(u(d, 1, rule, &bit));
    return bit == 1 || fail(d, "MarkerBit", rule, d->pos - 1, d->pos);
}

/* FBA-3: the length of the stuffing at pos, 0 if the bits there are something else. */
static unsigned stuffing(const struct decoder *d, uint64_t pos)
{
    unsigned count = 8 - (unsigned)(pos % 8);
    return has(d, pos, count) && peek(d, pos, count) == (1u << (count - 1)) - 1 ? count : 0;
}

/* ---- arithmetic segments: FBA-21..27 ---- */

struct coder {
    const struct decoder *d;
    uint64_t pos, bad_guard, fetched;
    uint64_t after[16]; /* positions behind the last 16 data bits */
    unsigned zeros;
    uint32_t low, high, code;
};

static unsigned next_raw(struct coder *c)
{
    unsigned bit = c->pos < c->d->bits ? peek(c->d, c->pos, 1) : 0;
    c->pos++;
    return bit;
}

static void next_data(struct coder *c)
{
    if (c->zeros == GUARD_AFTER) {
        if (next_raw(c) == 0 && c->bad_guard == UINT64_MAX)
            c->bad_guard = c->pos - 1;
        c->zeros = 0;
    }
    unsigned bit = next_raw(c);
    c->zeros = bit ? 0 : c->zeros + 1;
    c->after[c->fetched++ % 16] = c->pos;
    c->code = c->code << 1 | bit;
}

static uint32_t symbol(struct coder *c, struct channel *channel, bool intra, uint32_t count)
{
    uint32_t total = intra ? count : channel->total;
    uint32_t length = c->high - c->low + 1;
    uint32_t target = ((c->code - c->low + 1) * total - 1) / length;
    uint32_t s, below; /* below: cum[s + 1] */
    uint32_t width = 1;
    if (intra) { /* all frequencies are 1, so cum[s + 1] = count - 1 - s */
        s = count - 1 - target;
        below = target;
    } else {
        s = 0;
        below = total - channel->frequency[0];
        while (below > target)
            below -= channel->frequency[++s];
        width = channel->frequency[s];
    }
    c->high = c->low + length * (below + width) / total - 1;
    c->low += length * below / total;
    for (;;) {
        uint32_t shift;
        if (c->high < 32768)
            shift = 0;
        else if (c->low >= 32768)
            shift = 32768;
        else if (c->low >= 16384 && c->high < 49152)
            shift = 16384;
        else
            break;
        c->low = (c->low - shift) * 2;
        c->high = (c->high - shift) * 2 + 1;
        c->code -= shift;
        next_data(c);
    }
    if (!intra) {
        if (channel->total == MAX_FREQUENCY) {
            channel->total = 0;
            for (uint32_t i = 0; i < count; i++)
                channel->total += channel->frequency[i] = (uint16_t)((channel->frequency[i] + 1) / 2);
        }
        channel->frequency[s]++;
        channel->total++;
    }
    return s;
}

/* Decodes the selected channels (selected NULL: all) and sets their values: FBA-31, FBA-32. */
static bool segment(struct decoder *d, struct channel *channels, const uint16_t *order, const bool *selected,
                    unsigned count, bool intra)
{
    struct coder c = {.d = d, .pos = d->pos, .bad_guard = UINT64_MAX, .high = 65535};
    for (int i = 0; i < 16; i++)
        next_data(&c);
    for (unsigned i = 0; i < count; i++) {
        unsigned which = order == NULL ? i : order[i] - 1u;
        if (selected != NULL && !selected[which])
            continue;
        struct channel *channel = &channels[which];
        int32_t max = channel->force[intra ? I_MAX : P_MAX], min = channel->force[intra ? I_MIN : P_MIN];
        int64_t level = (int64_t)symbol(&c, channel, intra, (uint32_t)(max - min) + 1) + min;
        channel->value = (intra ? 0 : channel->value) + (channel->step == 0 ? level : level * channel->step);
    }
    uint64_t end = c.after[(c.fetched - 15) % 16]; /* FBA-26: 14 data bits are look-ahead */
    if (end > d->bits)
        return fail(d, "Truncated", "FBA-27", d->pos, d->bits);
    if (c.bad_guard < end)
        return fail(d, "MarkerBit", "FBA-25", c.bad_guard, c.bad_guard + 1);
    d->pos = end;
    return true;
}

/* ---- masks, limits, models ---- */

/* FBA-16: one range list; selected and channels by number - 1, order NULL: ascending from `first`. */
static bool limit_list(struct decoder *d, struct channel *channels, const bool *selected, const uint16_t *order,
                       unsigned first, const uint8_t *sizes, unsigned groups, int list)
{
    int32_t unit = list == I_MAX || list == P_MAX ? 60 : -60;
    unsigned at = first;
    for (unsigned group = 0; group < groups; group++)
        for (unsigned i = 0; i < sizes[group]; i++, at++) {
            unsigned which = order == NULL ? at : order[at] - 1u;
            if (i % 4 == 0)
                TRY(marker(d, "FBA-16"));
            if (selected[which]) {
                uint32_t v;
                TRY(u(d, 5, "FBA-16", &v));
                channels[which].limit[list] = unit * (int32_t)v;
            }
        }
    return true;
}

/* FBA-17, FBA-30: limits in force, and a fresh P model. */
static bool prepare(struct decoder *d, struct channel *channel, int32_t divisor, int64_t step)
{
    for (int i = 0; i < LISTS; i++)
        channel->force[i] = channel->limit[i] / divisor;
    channel->step = step;
    uint32_t count = (uint32_t)(channel->force[P_MAX] - channel->force[P_MIN]) + 1;
    if (count > channel->room) {
        uint16_t *larger = realloc(channel->frequency, count * sizeof *larger);
        if (larger == NULL)
            return give_up(d);
        channel->frequency = larger;
        channel->room = count;
    }
    for (uint32_t i = 0; i < count; i++)
        channel->frequency[i] = 1;
    channel->total = count;
    return true;
}

/* FBA-9..19, FBA-29..31 */
static bool face_header(struct decoder *d)
{
    TRY(u(d, 5, "FBA-9", &d->quant));
    unsigned fap = 0;
    for (unsigned group = 0; group < FAP_GROUPS; group++) {
        uint32_t type, mask = 0;
        unsigned size = FAP_GROUP_SIZE[group];
        TRY(marker(d, "FBA-10") && u(d, 2, "FBA-10", &type));
        if (type == 3)
            mask = (1u << size) - 1;
        else if (type != 0)
            TRY(u(d, size, "FBA-10", &mask));
        for (unsigned i = 0; i < size; i++, fap++) {
            d->selected[fap] = mask >> (size - 1 - i) & 1;
            d->interpolate[fap] = type == 2 && !d->selected[fap];
        }
    }
    uint32_t gender, coding, flag[LISTS];
    TRY(u(d, 1, "FBA-11", &gender) && u(d, 1, "FBA-12", &coding));
    if (coding == 1)
        return fail(d, "Unsupported", "FBA-12", d->pos - 1, d->pos);
    for (int i = 0; i < LISTS; i++)
        TRY(u(d, 1, "FBA-13", &flag[i]));
    struct channel *low_level = d->face + HIGH_LEVEL - 2; /* by FAP number - 1, from FAP 3 */
    for (int i = 0; i < LISTS; i++)
        if (flag[i])
            TRY(limit_list(d, low_level, d->selected, NULL, 2, FAP_GROUP_SIZE + 1, FAP_GROUPS - 1, i));
    int32_t quant = (int32_t)d->quant, divisor = quant == 0 ? 1 : quant;
    for (unsigned i = 2; i < FAPS; i++)
        if (d->selected[i])
            TRY(prepare(d, &low_level[i], divisor, (int64_t)FAP_QP[i] * d->quant));
    int32_t scaled = (63 + quant / 2) / divisor; /* FBA-29 */
    const int32_t top[HIGH_LEVEL] = {14, 14, scaled, 6, scaled, 6, scaled};
    for (unsigned i = 0; i < HIGH_LEVEL; i++) {
        bool select = i == 0 || i == 1 || i == 3 || i == 5;
        d->face[i].limit[I_MAX] = d->face[i].limit[P_MAX] = top[i];
        d->face[i].limit[I_MIN] = 0;
        d->face[i].limit[P_MIN] = -top[i];
        if (d->selected[i < VISEME ? 0 : 1])
            TRY(prepare(d, &d->face[i], 1, select ? 1 : quant));
    }
    return true;
}

static bool in_range(const struct channel *channel, int64_t most)
{
    return channel->value >= 0 && channel->value <= most;
}

/* FBA-28, FBA-32..34 */
static bool face_data(struct decoder *d, bool intra)
{
    uint64_t start = d->pos;
    const struct channel *face = d->face;
    uint32_t bit;
    if (intra) {
        TRY(face_header(d));
        d->face_seen = true;
        start = d->pos;
    }
    if (d->selected[0]) {
        TRY(segment(d, d->face, NULL, NULL, VISEME, intra));
        if (!in_range(&face[0], 14) || !in_range(&face[1], 14))
            return fail(d, "RangeViolation", "FBA-32", start, d->pos);
        TRY(u(d, 1, "FBA-28", &bit));
        d->viseme_def = bit;
        start = d->pos;
    }
    if (d->selected[1]) {
        TRY(segment(d, d->face + VISEME, NULL, NULL, EXPRESSION, intra));
        if (!in_range(&face[3], 6) || !in_range(&face[5], 6))
            return fail(d, "RangeViolation", "FBA-32", start, d->pos);
        TRY(u(d, 1, "FBA-28", &bit));
        d->init_face = bit;
        TRY(u(d, 1, "FBA-28", &bit));
        d->expression_def = bit;
    }
    TRY(segment(d, d->face + HIGH_LEVEL, NULL, d->selected + 2, FAPS - 2, intra));
    for (unsigned i = 0; i < FAPS; i++) {
        d->decoded[i] |= d->selected[i];
        d->state[i] = d->selected[i] ? 'T' : d->interpolate[i] ? 'I' : d->decoded[i] ? 'R' : 'U';
    }
    return true;
}

/* FBA-40 */
static bool body_data(struct decoder *d, bool intra)
{
    if (intra) {
        uint32_t quant, bit, flag[LISTS];
        TRY(u(d, 5, "FBA-40", &quant));
        const uint16_t *number = BAP_ORDER;
        for (unsigned group = 0; group < BAP_GROUPS; group++) {
            uint32_t type;
            TRY(marker(d, "FBA-40") && u(d, 2, "FBA-40", &type));
            if (type == 2)
                return fail(d, "ForbiddenValue", "FBA-40", d->pos - 2, d->pos);
            unsigned size = BAP_GROUP_SIZE[group];
            uint32_t mask = type == 3 ? (1u << size) - 1 : 0;
            if (type == 1)
                TRY(u(d, size, "FBA-40", &mask));
            while (size-- > 0)
                d->body_selected[*number++ - 1] = mask >> size & 1;
        }
        TRY(u(d, 1, "FBA-40", &bit) && u(d, 1, "FBA-40", &bit));
        if (bit == 1)
            return fail(d, "Unsupported", "FBA-40", d->pos - 1, d->pos);
        uint64_t flags_at = d->pos;
        bool all = true;
        for (int i = 0; i < LISTS; i++) {
            TRY(u(d, 1, "FBA-40", &flag[i]));
            all = all && flag[i];
        }
        for (int i = 0; i < LISTS; i++)
            if (flag[i])
                TRY(limit_list(d, d->body, d->body_selected, BAP_ORDER, 0, BAP_GROUP_SIZE, BAP_GROUPS, i));
        int32_t scale = BAP_SCALE[quant];
        for (unsigned i = 0; i < BAPS; i++)
            if (d->body_selected[i]) {
                if (i >= BAPS_WITH_LIMITS && !all)
                    return fail(d, "Unsupported", "FBA-40", flags_at, d->pos);
                TRY(prepare(d, &d->body[i], scale == 0 ? 1 : scale, (int64_t)BAP_BASE_STEP[i] * scale));
            }
        d->body_seen = true;
    }
    return segment(d, d->body, BAP_ORDER, d->body_selected, BAPS, intra);
}

/* ---- planes ---- */

/* FBA-6..8, FBA-37, FBA-38 */
static bool temporal_header(struct decoder *d, bool intra)
{
    uint32_t flag = 0;
    if (intra) {
        TRY(u(d, 1, "FBA-6", &flag));
        if (flag) {
            uint32_t whole, part, offset;
            TRY(u(d, 8, "FBA-6", &whole) && u(d, 4, "FBA-6", &part) && u(d, 1, "FBA-6", &offset));
            if (whole == 0 && part == 0)
                return fail(d, "ForbiddenValue", "FBA-37", d->pos - 13, d->pos);
            d->rate = whole * 16 + part;
            d->offset = offset;
        }
        TRY(u(d, 1, "FBA-7", &flag));
        if (flag) {
            uint32_t hours, minutes, seconds;
            TRY(u(d, 5, "FBA-7", &hours));
            if (hours > 23)
                return fail(d, "ForbiddenValue", "FBA-7", d->pos - 5, d->pos);
            TRY(u(d, 6, "FBA-7", &minutes));
            if (minutes > 59)
                return fail(d, "ForbiddenValue", "FBA-7", d->pos - 6, d->pos);
            TRY(marker(d, "FBA-7") && u(d, 6, "FBA-7", &seconds));
            if (seconds > 59)
                return fail(d, "ForbiddenValue", "FBA-7", d->pos - 6, d->pos);
            fba_time_set(&d->time, hours * 3600 + minutes * 60 + seconds);
        }
    }
    uint32_t skipped = 0;
    TRY(u(d, 1, "FBA-8", &flag));
    if (flag) {
        uint64_t start = d->pos;
        uint32_t part;
        do {
            TRY(u(d, 4, "FBA-8", &part));
            skipped += part;
            if (skipped > MAX_SKIP)
                return fail(d, "ResourceLimit", "FBA-8", start, d->pos);
        } while (part == 15);
    }
    d->shown = d->time;
    uint32_t over = d->offset ? 16 * 1001 : 16, under = d->offset ? d->rate * 1000 : d->rate;
    return fba_time_add(&d->time, (uint64_t)over * (skipped + 1), under) || give_up(d);
}

static void put(struct decoder *d, const char *form, ...)
{
    size_t room = LINE - d->length;
    va_list list;
    va_start(list, form);
    int length = vsnprintf(d->line + d->length, room, form, list);
    va_end(list);
    if (length < 0 || (size_t)length >= room)
        d->failed = true;
    else
        d->length += (size_t)length;
}

static bool flush(struct decoder *d)
{
    if (d->failed || d->write(d->user, d->line, d->length) != 0)
        return give_up(d);
    d->length = 0;
    return true;
}

/* CNF-1 */
static bool print_plane(struct decoder *d, bool intra, bool with_body)
{
    put(d, "{\"index\":%" PRIu64 ",\"time\":\"", d->index++);
    size_t length = fba_time_print(&d->shown, d->line + d->length, LINE - d->length);
    if (length == 0)
        return give_up(d);
    d->length += length;
    put(d, "\",\"intra\":%s,\"faps\":[null,null", intra ? "true" : "false");
    for (unsigned i = 2; i < FAPS; i++)
        if (d->state[i] == 'T' || d->state[i] == 'R')
            put(d, ",%" PRId64, d->face[HIGH_LEVEL + i - 2].value);
        else
            put(d, ",null");
    const struct channel *f = d->face;
    if (d->state[0] == 'T' || d->state[0] == 'R')
        put(d, "],\"viseme\":{\"select1\":%" PRId64 ",\"select2\":%" PRId64 ",\"blend\":%" PRId64 ",\"def\":%u}",
            f[0].value, f[1].value, f[2].value, d->viseme_def);
    else
        put(d, "],\"viseme\":null");
    if (d->state[1] == 'T' || d->state[1] == 'R')
        put(d,
            ",\"expression\":{\"select1\":%" PRId64 ",\"intensity1\":%" PRId64 ",\"select2\":%" PRId64
            ",\"intensity2\":%" PRId64 ",\"init_face\":%u,\"def\":%u}",
            f[3].value, f[4].value, f[5].value, f[6].value, d->init_face, d->expression_def);
    else
        put(d, ",\"expression\":null");
    put(d, ",\"state\":\"%s\"", d->state);
    if (with_body) {
        put(d, ",\"baps\":{");
        const char *separator = "";
        for (unsigned i = 0; i < BAPS; i++)
            if (d->body_selected[i]) {
                put(d, "%s\"%u\":%" PRId64, separator, i + 1, d->body[i].value);
                separator = ",";
            }
        put(d, "}");
    }
    put(d, "}\n");
    return flush(d);
}

/* FBA-5, FBA-35 */
static bool plane(struct decoder *d, uint32_t *is_intra, uint32_t *mask)
{
    uint64_t start = d->pos;
    TRY(u(d, 1, "FBA-5", is_intra) && u(d, 2, "FBA-5", mask));
    bool intra = *is_intra == 1;
    if (!intra && (((*mask & 1) && !d->face_seen) || ((*mask & 2) && !d->body_seen)))
        return fail(d, "InconsistentSemantics", "FBA-35", start, start + 1);
    TRY(temporal_header(d, intra));
    if (*mask & 1)
        TRY(face_data(d, intra));
    else
        for (unsigned i = 0; i < FAPS; i++)
            if (d->state[i] == 'T')
                d->state[i] = 'R';
    return !(*mask & 2) || body_data(d, intra);
}

/* FBA-1..3, FBA-42, FBA-44 */
static bool object(struct decoder *d)
{
    unsigned idle_planes = 0;
    for (bool first = true;; first = false) {
        if (d->pos >= d->ones_end)
            return true;
        bool start_code = false;
        unsigned stuffed = stuffing(d, d->pos);
        uint64_t code_at = d->pos + stuffed;
        if (stuffed != 0 && code_at == d->bits)
            return true;
        if (stuffed != 0 && has(d, code_at, 24) && peek(d, code_at, 24) == 1) {
            if (!has(d, code_at, 32))
                return fail(d, "Truncated", "FBA-44", code_at, d->bits);
            if (peek(d, code_at, 32) != 0x1BB)
                return true;
            start_code = true;
        } else if (first && has(d, d->pos, 32) && peek(d, d->pos, 32) == 0x1BB) {
            start_code = true;
            code_at = d->pos;
        }
        if (start_code)
            d->pos = code_at + 32;
        uint64_t plane_at = d->pos;
        uint32_t intra, mask;
        TRY(plane(d, &intra, &mask));
        idle_planes = mask != 0 ? 0 : start_code ? 1 : idle_planes + 1;
        if (idle_planes > MAX_IDLE)
            return fail(d, "ResourceLimit", "FBA-42", plane_at, d->pos);
        TRY(print_plane(d, intra, mask & 2));
    }
}

/* ---- what stands before the object: SYS-1..7 ---- */

/* Skips user data and reads the start code behind it. */
static bool start_code(struct decoder *d, uint32_t *code)
{
    for (;;) {
        uint64_t at = d->pos;
        TRY(u(d, 32, "SYS-1", code));
        if (*code != 0x1B2)
            return true;
        while (has(d, d->pos, 24) && peek(d, d->pos, 24) != 1)
            d->pos += 8;
        if (!has(d, d->pos, 24))
            return fail(d, "Truncated", "SYS-5", at, d->bits);
    }
}

static bool headers(struct decoder *d)
{
    uint32_t code, value, type;
    if (d->bits < 32)
        return fail(d, "InputFormat", "FBA-44", 0, d->bits);
    TRY(u(d, 32, "FBA-1", &code));
    if (code == 0x1BC)
        return fail(d, "Unsupported", "SYS-7", 0, 32);
    if (code == 0x1BA)
        return true;
    if ((code >= 0x100 && code <= 0x12F) || code == 0x1BE)
        return fail(d, "Unsupported", "SYS-4", 0, 32);
    if (code == 0x1B1 || code == 0x1B2 || code == 0x1B5 || code == 0x1BB || code == 0x1BD)
        return fail(d, "InconsistentSemantics", "SYS-7", 0, 32);
    if (code != 0x1B0)
        return fail(d, "InputFormat", "FBA-1", 0, 32);
    for (;;) {
        TRY(u(d, 8, "SYS-2", &value));
        TRY(start_code(d, &code));
        if (code != 0x1B1 || !has(d, d->pos, 32) || peek(d, d->pos, 32) != 0x1B0)
            break;
        d->pos += 32; /* a sequence without objects, and another one behind it */
    }
    if (code != 0x1B5)
        return fail(d, "InconsistentSemantics", "SYS-2", d->pos - 32, d->pos);
    TRY(u(d, 1, "SYS-3", &value));
    if (value) {
        TRY(u(d, 4, "SYS-3", &value) && u(d, 3, "SYS-3", &value));
        if (value == 0)
            return fail(d, "ReservedValue", "SYS-3", d->pos - 3, d->pos);
    }
    TRY(u(d, 4, "SYS-4", &type));
    if (type == 0 || type > 5)
        return fail(d, "ReservedValue", "SYS-4", d->pos - 4, d->pos);
    if (type != 3 && type != 4)
        return fail(d, "Unsupported", "SYS-4", d->pos - 4, d->pos);
    unsigned stuffed = stuffing(d, d->pos);
    if (stuffed == 0) /* after 5 or 12 bits some bits of the byte are left, so nothing can be missing */
        return fail(d, "ForbiddenValue", "SYS-3", d->pos, (d->pos + 7) / 8 * 8);
    d->pos += stuffed;
    TRY(start_code(d, &code));
    if (code != (type == 4 ? 0x1BAu : 0x1BCu))
        return fail(d, "InconsistentSemantics", "SYS-6", d->pos - 32, d->pos);
    if (type == 3)
        return fail(d, "Unsupported", "SYS-4", d->pos - 32, d->pos);
    return true;
}

static int32_t outward(int32_t limit)
{
    return (limit + 59) / 60 * 60;
}

static void start(struct decoder *d)
{
    memset(d->state, 'U', FAPS);
    d->rate = 30 * 16;
    fba_time_set(&d->time, 0);
    for (unsigned i = 2; i < FAPS; i++) {
        int32_t *limit = d->face[HIGH_LEVEL + i - 2].limit;
        limit[I_MAX] = outward(FAP_INTRA_MAX[i]);
        limit[I_MIN] = -limit[I_MAX];
        limit[P_MAX] = outward(FAP_INTER_MAX[i]);
        limit[P_MIN] = -limit[P_MAX];
    }
    for (unsigned i = 0; i < BAPS_WITH_LIMITS; i++)
        for (int k = 0; k < LISTS; k++)
            d->body[i].limit[k] = BAP_DEFAULT[i][k];
}

enum fba_result fba_decode(const uint8_t *data, size_t size, fba_write write, void *user, struct fba_error *error)
{
    struct decoder *d = calloc(1, sizeof *d);
    if (d == NULL || size > UINT64_MAX / 16) {
        free(d);
        return FBA_FAILED;
    }
    d->data = data;
    d->bits = (uint64_t)size * 8;
    d->write = write;
    d->user = user;
    d->error = error;
    for (size_t i = size; i > 0 && d->ones_end == 0; i--)
        for (unsigned k = 0; k < 8 && d->ones_end == 0; k++)
            if (data[i - 1] >> k & 1)
                d->ones_end = (uint64_t)i * 8 - k;
    start(d);
    bool accepted = headers(d);
    if (accepted) {
        put(d, "{\"format\":\"snhc-decoded\",\"version\":1,\"kind\":\"fba\"}\n");
        accepted = flush(d) && object(d);
    }
    bool failed = d->failed;
    for (unsigned i = 0; i < FACE; i++)
        free(d->face[i].frequency);
    for (unsigned i = 0; i < BAPS; i++)
        free(d->body[i].frequency);
    free(d);
    return failed ? FBA_FAILED : accepted ? FBA_ACCEPTED : FBA_REJECTED;
}
