/* Functions that extern.meld declares. */
#include <math.h>
#include <meld/extern.h>

double half(int64_t x) { return (double)x / 2; }
bool is_odd(int64_t x) { return x % 2 != 0; }
uint64_t other(uint64_t node) { return 1 - node; }
double root(double x) { return sqrt(x); }

double mean(meld_value l) {
    double sum = 0;
    for (uint32_t i = 0; i < meld_count(l); ++i) sum += meld_float(l->items[i]);
    return meld_count(l) ? sum / meld_count(l) : 0;
}

meld_value countdown(meld_call* call, int64_t n) {
    uint64_t* items = meld_items(call, (uint32_t)n);
    for (int64_t i = 0; i < n; ++i) items[i] = meld_word_of_int(n - i);
    return meld_make(call, items, (uint32_t)n);
}

meld_value shout(meld_call* call, meld_value text) {
    char upper[100];
    uint32_t n = meld_count(text) < 100 ? meld_count(text) : 100;
    for (uint32_t i = 0; i < n; ++i) {
        char c = meld_bytes(text)[i];
        upper[i] = c >= 'a' && c <= 'z' ? (char)(c - 32) : c;
    }
    return meld_string(call, upper, n);
}

meld_value disorder(meld_call* call) {
    uint64_t* items = meld_items(call, 3);
    items[0] = 3, items[1] = 1, items[2] = 3;
    return meld_make(call, items, 3);
}

int64_t open_box(int64_t n) { return n * 7; }
int64_t look(int64_t box) { return box / 7; }

double nothing(void) { return 0.0 / 0.0; }
