// Answers with one mistake in them, which a judge must find.
#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "tests/reference/answers/inquiry.h"
#include "tests/reference/programs/body.h"

namespace meld::reference {

namespace {

using Json = nlohmann::ordered_json;

// Adds one to a number in a text, chosen by chance. False: there is none.
bool change_number(Random& random, std::string& text) {
    std::vector<std::size_t> ends;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto digit = [&](std::size_t at) { return at < text.size() && text[at] >= '0' && text[at] <= '9'; };
        const bool begins = digit(i) && (i == 0 || text[i - 1] == ' ' || text[i - 1] == '(' || text[i - 1] == '@' || text[i - 1] == '-');
        if (begins && text.find('"') == std::string::npos) ends.push_back(i);
    }
    if (ends.empty()) return false;
    const std::size_t at = pick(random, ends);
    text[at] = text[at] == '9' ? '8' : static_cast<char>(text[at] + 1);
    return true;
}

class Falsifier {
  public:
    Falsifier(Random& random, Inquiry& inquiry) : random_(random), why_(inquiry.kind == Inquiry::Kind::Why), answer_(inquiry.answer) {}

    std::string run() {
        if (answer_.at("nodes").empty()) return "";
        const std::vector<std::function<std::string()>> all = {[&] { return part(); },  [&] { return number(); }, [&] { return line(); },
                                                               [&] { return fact(); },  [&] { return way(); },    [&] { return tick(); },
                                                               [&] { return value(); }, [&] { return rank(); }};
        // The first of them that can be done, from one by chance.
        const auto first = static_cast<std::size_t>(below(random_, static_cast<std::int64_t>(all.size())));
        for (std::size_t n = 0; n < all.size(); ++n)
            if (std::string done = all[(first + n) % all.size()](); !done.empty()) return done;
        return "";
    }

  private:
    // Some way by a rule of which this holds.
    Json* some_way(const std::function<bool(const Json& node, const Json& way)>& fits) {
        std::vector<Json*> found;
        for (Json& node : answer_["nodes"])
            for (Json& way : node["ways"])
                if (way.contains("text") && fits(node, way)) found.push_back(&way);
        return found.empty() ? nullptr : pick(random_, found);
    }
    static bool some_fail(const Json& way) { return !way["parts"].empty() && way["parts"].back()["is"] == "fails"; }

    // Of what is there, everything; of what is missing, that which fails.
    std::string part() {
        Json* const way = some_way([&](const Json&, const Json& w) { return why_ ? !w["parts"].empty() : some_fail(w); });
        if (way == nullptr) return "";
        Json& parts = (*way)["parts"];
        const std::size_t at = why_ ? static_cast<std::size_t>(below(random_, static_cast<std::int64_t>(parts.size()))) : parts.size() - 1;
        const std::string text = parts[at]["text"];
        parts.erase(at);
        return "without the part " + text;
    }
    std::string number() {
        Json* const way = some_way([&](const Json&, const Json& w) { return why_ ? !w["parts"].empty() : some_fail(w); });
        if (way == nullptr) return "";
        Json& parts = (*way)["parts"];
        Json& part = why_ ? parts[static_cast<std::size_t>(below(random_, static_cast<std::int64_t>(parts.size())))] : parts.back();
        std::string text = part["text"];
        if (!change_number(random_, text)) return "";
        part["text"] = text;
        return "another number in " + text;
    }
    std::string line() {
        Json* const way = some_way([](const Json&, const Json&) { return true; });
        if (way == nullptr) return "";
        (*way)["line"] = (*way)["line"].get<std::int64_t>() + (chance(random_, 50) ? 1 : -1);
        return fmt::format("line {}", (*way)["line"].get<std::int64_t>());
    }
    // The fact of a node, wherever it stands.
    std::string fact() {
        Json& nodes = answer_["nodes"];
        const auto at = static_cast<std::size_t>(below(random_, static_cast<std::int64_t>(nodes.size())));
        std::string text = nodes[at]["fact"];
        if (!change_number(random_, text)) return "";
        nodes[at]["fact"] = text;
        for (Json& node : nodes)
            for (Json& way : node["ways"])
                for (Json& part : way["parts"])
                    if (part.contains("node") && part["node"] == at && part["is"] == "fact") part["text"] = text;
        return "the fact " + text;
    }
    // What is combined has no way too few, and what is missing no rule too few. That a rule cannot be looked up is no way.
    std::string way() {
        std::vector<Json*> found;
        const auto is_way = [](const Json& way) {
            return way.contains("text") && way.value("note", "").find("cannot be looked up") == std::string::npos;
        };
        for (Json& node : answer_["nodes"])
            if (!node["ways"].empty() && (node["is"] == "combined" || node["is"] == "missing") && is_way(node["ways"][0]))
                found.push_back(&node);
        if (found.empty()) return "";
        Json& ways = (*pick(random_, found))["ways"];
        const std::string text = ways[0]["text"];
        ways.erase(0);
        return "without the way by " + text;
    }
    std::string tick() {
        Json& nodes = answer_["nodes"];
        Json& node = nodes[static_cast<std::size_t>(below(random_, static_cast<std::int64_t>(nodes.size())))];
        node["tick"] = answer_["tick"].get<std::int64_t>() + 1;
        return fmt::format("{} in tick {}", node["fact"].get<std::string>(), node["tick"].get<std::int64_t>());
    }
    std::string value() {
        if (!why_) return "";
        Json* const way = some_way([](const Json&, const Json& w) { return w.contains("with"); });
        if (way == nullptr) return "";
        Json& with = (*way)["with"];
        auto entry = with.begin();
        std::advance(entry, below(random_, static_cast<std::int64_t>(with.size())));
        std::string text = entry.value();
        if (!change_number(random_, text)) return "";
        entry.value() = text;
        return fmt::format("{} = {}", entry.key(), text);
    }
    // A fact rests on one of its own predicate and rank.
    std::string rank() {
        for (Json& node : answer_["nodes"])
            for (Json& way : node["ways"])
                for (Json& part : way["parts"]) {
                    if (!part.contains("node") || !node.contains("rank") || node.contains("note")) continue;
                    Json& below = answer_["nodes"][part["node"].get<std::size_t>()];
                    const auto name = [](const Json& n) {
                        return n["fact"].get<std::string>().substr(0, n["fact"].get<std::string>().find('('));
                    };
                    const auto open = [](const Json& n) { return n["fact"].get<std::string>().find(", _") != std::string::npos; };
                    if (!below.contains("rank") || name(node) != name(below) || open(node) != open(below)) continue;
                    below["rank"] = node["rank"];
                    return fmt::format("rank {} of {}", node["rank"].get<std::uint64_t>(), below["fact"].get<std::string>());
                }
        return "";
    }

    Random& random_;
    bool why_;
    Json& answer_;
};

}  // namespace

std::string falsify(Random& random, Inquiry& inquiry) {
    if (inquiry.kind == Inquiry::Kind::Query || !inquiry.error.empty()) return "";
    return Falsifier(random, inquiry).run();
}

}  // namespace meld::reference
