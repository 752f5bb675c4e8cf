// Frames of a run one after the other, each as what has changed since the one before, for a page that keeps a state and changes it.
//
// A record, in little endian: 12 numbers of 32 bits: kind (0: the state before counts for nothing; 1: it changes; and 2 more if catoms that
// are set come with their bodies, which are no spheres), tick (low, high), catoms of the run, removed, set, whether strokes, labels and
// triangles follow (otherwise they stay), lines, arrows, labels, bytes of facts, triangles. Then the ids of removed catoms (all low words,
// all high words), and of those that are set the same, their places (3 floats), diameters and colours (32 bits each, see Colours), and with
// bodies first half the edges of all cores with their roundings, then how all are turned: x, y, z, w (4 floats each); lines, arrows, labels
// and triangles as in a frame block; and facts as JSON, padded with spaces to 4 bytes: by ids, the list of a catom that has changed. Catoms
// are in the order of their ids; a label's catom is its place in that order.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <unordered_map>
#include <vector>

#include "runtime/show/picture/frame.h"

namespace meld::view {

// The JSON lists of facts of catoms, by their ids.
using FactsOfCatoms = std::map<std::uint64_t, std::string>;

class Changes {
  public:
    // What stands for a catom's colour: red, green, blue and 255; its number as a float; or the place of its word, from 1; 0: none. A
    // number that is no float is NaN with its place in numbers(), from 1, as payload; no payload: none. In frames before the first value
    // NaN stands for none, whatever values are.
    enum class Colours { Own, Numbers, Words };

    // Whether its colours stand for something else than those of the frames so far: its record has all of it.
    bool changes_colours(const picture::Frame& frame) const { return kind_of(frame) != colours_; }
    // The record of the next frame. `key`: with all of it.
    std::string record(const picture::Frame& frame, FactsOfCatoms facts, bool key);

    // As of the first frame in which some catom has a value; those before have none.
    Colours colours() const { return colours_; }
    const std::vector<std::string>& words() const { return words_; }
    // Those that no float is, as they came; of very many that differ, the others are the nearest float.
    const std::vector<render::Number>& numbers() const { return numbers_; }

  private:
    struct State {
        std::vector<std::uint64_t> ids = {};
        std::vector<render::Vec> places = {};
        std::vector<float> diameters = {};
        std::vector<std::uint32_t> colours = {};
        std::vector<render::RoundedBody> bodies = {};  // Empty where all are spheres.
        std::string strokes = {};
        FactsOfCatoms facts = {};
        bool same(std::size_t i, const State& other, std::size_t j) const;
    };
    Colours kind_of(const picture::Frame& frame) const {
        return !frame.words.empty() ? Colours::Words : !frame.numbers.empty() ? Colours::Numbers : colours_;
    }
    std::vector<std::uint32_t> colours_of(const picture::Frame& frame);
    std::uint32_t stands_for(render::Number number, bool whole);

    State before_;
    Colours colours_ = Colours::Own;
    std::vector<std::string> words_;
    std::map<std::string, std::uint32_t> places_of_words_;
    std::vector<render::Number> numbers_;
    std::unordered_map<render::Number, std::uint32_t> places_of_numbers_;
};

}  // namespace meld::view
