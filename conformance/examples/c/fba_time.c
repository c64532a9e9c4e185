#include "fba_time.h"

#include <inttypes.h>
#include <stdio.h>

static void set(struct fba_number *number, uint32_t value)
{
    number->used = 1;
    number->limb[0] = value % TIME_LIMB;
    if (value >= TIME_LIMB) {
        number->used = 2;
        number->limb[1] = value / TIME_LIMB;
    }
}

static bool multiply(struct fba_number *number, uint64_t factor)
{
    uint64_t carry = 0;
    for (size_t i = 0; i < number->used; i++) {
        carry += number->limb[i] * factor; /* at most 10^9 * factor: fits 64 bits for factors below 1.8e10 */
        number->limb[i] = (uint32_t)(carry % TIME_LIMB);
        carry /= TIME_LIMB;
    }
    for (; carry != 0; carry /= TIME_LIMB) {
        if (number->used == TIME_LIMBS)
            return false;
        number->limb[number->used++] = (uint32_t)(carry % TIME_LIMB);
    }
    return true;
}

static bool add(struct fba_number *number, const struct fba_number *other)
{
    uint32_t carry = 0;
    for (size_t i = 0; i < other->used || carry != 0; i++) {
        if (i == TIME_LIMBS)
            return false;
        if (i >= number->used) {
            number->limb[i] = 0;
            number->used = i + 1;
        }
        carry += number->limb[i] + (i < other->used ? other->limb[i] : 0);
        number->limb[i] = carry % TIME_LIMB;
        carry /= TIME_LIMB;
    }
    return true;
}

static uint32_t remainder_of(const struct fba_number *number, uint32_t divisor)
{
    uint64_t rest = 0;
    for (size_t i = number->used; i-- > 0;)
        rest = (rest * TIME_LIMB + number->limb[i]) % divisor;
    return (uint32_t)rest;
}

static void divide(struct fba_number *number, uint32_t divisor)
{
    uint64_t rest = 0;
    for (size_t i = number->used; i-- > 0;) {
        rest = rest * TIME_LIMB + number->limb[i];
        number->limb[i] = (uint32_t)(rest / divisor);
        rest %= divisor;
    }
    while (number->used > 1 && number->limb[number->used - 1] == 0)
        number->used--;
}

static uint64_t common(uint64_t a, uint64_t b)
{
    while (b != 0) {
        uint64_t rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

void fba_time_set(struct fba_time *time, uint32_t seconds)
{
    set(&time->over, seconds);
    set(&time->under, 1);
}

bool fba_time_add(struct fba_time *time, uint64_t over, uint32_t under)
{
    uint64_t shared = common(over, under);
    over /= shared;
    under = (uint32_t)(under / shared);
    struct fba_number part = time->under;
    if (!multiply(&part, over) || !multiply(&time->over, under) || !add(&time->over, &part) ||
        !multiply(&time->under, under))
        return false;
    for (;;) { /* only primes of `under` can have become common */
        uint32_t factor = (uint32_t)common(under, remainder_of(&time->over, under));
        factor = (uint32_t)common(factor, remainder_of(&time->under, factor));
        if (factor == 1)
            return true;
        divide(&time->over, factor);
        divide(&time->under, factor);
    }
}

static size_t print(const struct fba_number *number, char *text, size_t room)
{
    if (room < 9 * number->used + 2)
        return 0;
    size_t length = (size_t)snprintf(text, room, "%" PRIu32, number->limb[number->used - 1]);
    for (size_t i = number->used - 1; i-- > 0;)
        length += (size_t)snprintf(text + length, room - length, "%09" PRIu32, number->limb[i]);
    return length;
}

size_t fba_time_print(const struct fba_time *time, char *text, size_t room)
{
    size_t length = print(&time->over, text, room);
    if (length == 0)
        return 0;
    text[length++] = '/';
    size_t more = print(&time->under, text + length, room - length);
    return more == 0 ? 0 : length + more;
}
