#include "runtime/world/file/network_section.h"

#include <fmt/format.h>

#include <algorithm>

#include "runtime/world/file/link_terms.h"

namespace meld::world {
namespace {

constexpr std::uint64_t kMostTries = 1'000;

void read_ticks(const Section& section, std::string_view key, std::uint32_t& value, std::uint64_t most = kMostTicks) {
    std::uint64_t ticks = value;
    section.read_count(key, ticks, 1, most);
    value = static_cast<std::uint32_t>(ticks);
}

void read_terms(const Section& section, NetworkKind kind, LinkTerms& terms) {
    read_ticks(section, "least", terms.least);
    terms.most = std::max(terms.most, terms.least);
    read_ticks(section, "most", terms.most);
    if (terms.most < terms.least) section.wrong("most", fmt::format("most is {}, and least is {}", terms.most, terms.least));
    if (kind == NetworkKind::Lossy || kind == NetworkKind::Raw) section.read_number("loss", terms.loss, 0, 1);
    if (kind == NetworkKind::Lossy) {
        read_ticks(section, "retry", terms.retry);
        read_ticks(section, "tries", terms.tries, kMostTries);
        if (terms.bound() > kMostTicks)
            section.wrong("tries", fmt::format("a message may be under way for {} ticks, and the maximum is {}", terms.bound(), kMostTicks),
                          "make retry or tries smaller");
    }
    if (kind == NetworkKind::Raw) {
        section.read_number("duplicate", terms.duplicate, 0, 1);
        section.read("reorder", terms.reorder);
    }
}

// The keys of each kind, after `kind` itself.
std::vector<std::string_view> keys_of(NetworkKind kind) {
    switch (kind) {
        case NetworkKind::Ideal:
            return {};
        case NetworkKind::Latency:
            return {"least", "most"};
        case NetworkKind::Lossy:
            return {"least", "most", "loss", "retry", "tries"};
        case NetworkKind::Raw:
            return {"least", "most", "loss", "duplicate", "reorder"};
    }
    return {};
}

void refuse_others(const Section& section, const toml::table& table, const std::string& kind, std::vector<std::string_view> keys,
                   std::initializer_list<std::string_view> more) {
    keys.insert(keys.end(), more);
    for (const auto& [key, node] : table)
        if (std::ranges::find(keys, key.str()) == keys.end())
            section.wrong(key.str(), fmt::format("`{}` says nothing of what is {}", key.str(), kind),
                          "take it out, or choose another kind");
}

}  // namespace

void read_network(TomlReader& reader, const toml::table& table, NetworkOptions& network) {
    const Section section(
        reader, table, "[network]",
        {"kind", "least", "most", "loss", "retry", "tries", "duplicate", "reorder", "region", "longest_jam", "reach", "links", "detect"});
    std::string kind = "ideal", reach = "links";
    section.read_choice("kind", kind, {"ideal", "latency", "lossy", "raw"});
    network.kind = kind == "latency" ? NetworkKind::Latency
                   : kind == "lossy" ? NetworkKind::Lossy
                   : kind == "raw"   ? NetworkKind::Raw
                                     : NetworkKind::Ideal;
    section.read_choice("reach", reach, {"links", "any"});
    if (table.contains("reach")) network.reach = reach == "any" ? Reach::Any : Reach::Links;
    const std::vector<std::string_view> keys = keys_of(network.kind);
    refuse_others(section, table, kind, keys, {"kind", "region", "longest_jam", "reach", "detect", network.ideal() ? "kind" : "links"});
    // It is the events' (event_section.cpp), which know how long theirs are.
    std::uint32_t longest_jam = 1;
    read_ticks(section, "longest_jam", longest_jam);
    std::uint64_t detect = 0;
    section.read_count("detect", detect, 0, kMostTicks);
    network.detect = static_cast<std::uint32_t>(detect);
    read_terms(section, network.kind, network.terms);
    if (section.has("links")) {
        std::string name;
        section.read("links", name);
        read_link_terms(reader, section, name, keys, network);
    }
    const toml::node* regions = section.find("region");
    if (regions == nullptr) return;
    if (network.ideal()) return section.wrong("region", "links of an ideal network are all alike", "take it out, or choose another kind");
    const toml::array* all = regions->as_array();
    if (all == nullptr || all->empty() || !all->is_homogeneous(toml::node_type::table))
        return section.wrong("region", "a region of the network is a table", "write [[network.region]] with `where` and its terms");
    for (const toml::node& node : *all) {
        const Section one(reader, *node.as_table(), "[[network.region]]",
                          {"where", "least", "most", "loss", "retry", "tries", "duplicate", "reorder"});
        refuse_others(one, *node.as_table(), kind, keys, {"where"});
        NetworkOptions::Part part{.where = {}, .terms = network.terms, .place = reader.place(node.source())};
        const std::optional<Region> where = one.read_region("where");
        if (!where && !one.has("where")) return one.wrong("where", "it does not say which links are meant", "add where = \"...\"");
        if (where) part.where = *where, part.place = reader.place(one.find("where")->source());
        if (one.has("least") && !one.has("most")) part.terms.most = 1;
        read_terms(one, network.kind, part.terms);
        network.parts.push_back(std::move(part));
    }
}

void read_clock(TomlReader& reader, const toml::table& table, ClockOptions& clock) {
    const Section section(reader, table, "[clock]", {"kind", "rate", "most"});
    std::string kind = "synchronous";
    section.read_choice("kind", kind, {"synchronous", "random", "drift", "priority", "sequential"});
    clock.kind = kind == "random"       ? ClockKind::Random
                 : kind == "drift"      ? ClockKind::Drift
                 : kind == "priority"   ? ClockKind::Priority
                 : kind == "sequential" ? ClockKind::Sequential
                                        : ClockKind::Synchronous;
    const auto needs = [&](std::string_view key, std::string cure) {
        if (!section.has(key)) section.wrong("kind", fmt::format("a clock that is {} needs `{}`", kind, key), std::move(cure));
    };
    if (clock.synchronous() || clock.gives_turns()) {
        refuse_others(section, table, kind, {"kind"}, {});
        return;
    }
    needs("most", "add most = N: no catom pauses for N ticks or more");
    read_ticks(section, "most", clock.most);
    if (clock.kind == ClockKind::Drift) return refuse_others(section, table, kind, {"kind", "most"}, {});
    needs("rate", "add rate = P, the probability that a catom acts in a tick");
    section.read_number("rate", clock.rate, 0, 1);
}

}  // namespace meld::world
