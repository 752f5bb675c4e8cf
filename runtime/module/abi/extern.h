// The interface of a C or C++ function that a Meld program declares with `extern`. Include it as <meld/extern.h>.
//
//     extern float mean(list float).        double mean(meld_value list);
//     extern list int range(int).           meld_value range(meld_call* call, int64_t n);
//
// int is int64_t, float double, bool bool, node uint64_t (its number), a type of your own (`extern type handle.`) int64_t; all others are a
// meld_value. A function that returns a meld_value takes a meld_call first: what it makes lives as long as the result is needed, and is
// never freed by hand. Functions must be pure: they return the same for the same arguments, change nothing, and may be called at any time,
// from several threads at once, any number of times.
#pragma once

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#else
#include <stdbool.h>
#endif

/* A list, set, array, struct, tuple, vec3 or string. NULL is the empty one. Never change what it points to. */
struct meld_list {
    const uint64_t* items; /* The elements or fields, a word each; of a string its bytes, in UTF-8 and without an end mark. */
    uint32_t count;        /* Elements, fields or bytes. */
    uint32_t reserved;
};
typedef const struct meld_list* meld_value;
typedef struct Eval meld_call;

/* Memory for what a function makes. */
void* meld_allocate(meld_call* call, uint64_t bytes);

static inline uint32_t meld_count(meld_value v) { return v ? v->count : 0; }

/* A word as what it is. */
static inline int64_t meld_int(uint64_t word) { return (int64_t)word; }
static inline double meld_float(uint64_t word) {
    double value;
    __builtin_memcpy(&value, &word, sizeof value);
    return value;
}
static inline meld_value meld_nested(uint64_t word) { return (meld_value)(uintptr_t)word; }
static inline const char* meld_bytes(meld_value string) { return string ? (const char*)string->items : ""; }

/* And back. */
static inline uint64_t meld_word_of_int(int64_t value) { return (uint64_t)value; }
static inline uint64_t meld_word_of_float(double value) {
    uint64_t word;
    __builtin_memcpy(&word, &value, sizeof word);
    return word;
}
static inline uint64_t meld_word_of(meld_value value) { return (uint64_t)(uintptr_t)value; }

/* Words to fill in, and the value made of them. */
static inline uint64_t* meld_items(meld_call* call, uint32_t count) { return (uint64_t*)meld_allocate(call, count * sizeof(uint64_t)); }
static inline meld_value meld_make(meld_call* call, const uint64_t* items, uint32_t count) {
    struct meld_list* made;
    if (count == 0) return 0;
    made = (struct meld_list*)meld_allocate(call, sizeof *made);
    made->items = items;
    made->count = count;
    made->reserved = 0;
    return made;
}
static inline meld_value meld_string(meld_call* call, const char* bytes, uint32_t count) {
    char* copy = (char*)meld_allocate(call, count);
    __builtin_memcpy(copy, bytes, count);
    return meld_make(call, (const uint64_t*)(const void*)copy, count);
}

#ifdef __cplusplus
}
#endif
