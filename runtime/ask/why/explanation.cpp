#include "runtime/ask/why/explanation.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

namespace meld::inspect {

namespace {

using Json = nlohmann::ordered_json;
using Node = Explanation::Node;
using Part = Explanation::Part;
using Way = Explanation::Way;

const char* name_of(Node::Is is) {
    switch (is) {
        case Node::Is::Given:
            return "given";
        case Node::Is::Sensed:
            return "sensed";
        case Node::Is::Derived:
            return "derived";
        case Node::Is::Combined:
            return "combined";
        case Node::Is::Made:
            return "made";
        case Node::Is::Further:
            return "further";
        case Node::Is::Unknown:
            return "unknown";
        case Node::Is::Missing:
            return "missing";
    }
    return "";
}

const char* name_of(Part::Is is) {
    switch (is) {
        case Part::Is::Fact:
            return "fact";
        case Part::Is::Absent:
            return "absent";
        case Part::Is::Condition:
            return "condition";
        case Part::Is::Fails:
            return "fails";
    }
    return "";
}

std::string place_of(const Way& way) { return way.file.empty() ? "" : fmt::format("{}:{}: ", way.file, way.line); }

// Lines of a tree, written without recursion: a chain of facts may be as long as the ensemble.
class Lines {
  public:
    explicit Lines(const Explanation& all) : all_(all), shown_(all.nodes.size(), false) {}

    std::string take() {
        for (const std::size_t root : all_.roots) {
            push_node(root, 0);
            while (!todo_.empty()) {
                const Todo next = todo_.back();
                todo_.pop_back();
                if (next.way == kNoWay)
                    node(next);
                else
                    part(next);
            }
        }
        if (all_.more > 0) out_ += fmt::format("... and {} more that match\n", all_.more);
        return std::move(out_);
    }

  private:
    static constexpr std::size_t kNoWay = ~std::size_t{0};
    struct Todo {
        std::size_t node, way = kNoWay, part = 0, indent = 0;
    };
    // Deep trees go to the right only so far; what is further names its depth.
    static constexpr std::size_t kMostIndent = 40;

    void line(std::size_t indent, const std::string& text) {
        if (indent > kMostIndent)
            out_ += fmt::format("{:>{}} ", fmt::format("[{}]", indent), 2 * kMostIndent + 6);
        else
            out_ += std::string(2 * indent, ' ');
        out_ += text + "\n";
    }
    void push_node(std::size_t node, std::size_t indent) { todo_.push_back({.node = node, .indent = indent}); }

    static bool leaf(const Node& n) { return n.ways.empty() && n.others.empty() && n.note.empty(); }

    std::string title(const Node& n) const {
        std::string text = n.fact;
        if (n.tick != all_.tick) text += fmt::format("  in tick {}", n.tick);
        if (n.is == Node::Is::Missing)
            text += "  does not hold";
        else if (n.is != Node::Is::Derived && n.is != Node::Is::Unknown)
            text += fmt::format("  {}", name_of(n.is));
        if (n.rank != kAbsent) text += fmt::format("  rank {}", n.rank);
        return text;
    }
    void node(const Todo& at) {
        const Node& n = all_.nodes[at.node];
        if (shown_[at.node] && !leaf(n)) return line(at.indent, title(n) + "  (see above)");
        shown_[at.node] = true;
        line(at.indent, title(n));
        if (!n.note.empty()) line(at.indent + 1, n.note);
        // In the order in which they are to be written, from the last.
        std::vector<Todo> parts;
        for (std::size_t w = 0; w < n.ways.size(); ++w) parts.push_back({at.node, w, 0, at.indent + 1});
        todo_.insert(todo_.end(), parts.rbegin(), parts.rend());
        if (n.ways.empty()) tail(n, at.indent + 1);
    }
    void tail(const Node& n, std::size_t indent) {
        if (n.more > 0) line(indent, fmt::format("... and {} more", n.more));
        for (const std::string& other : n.others) line(indent, "not " + other);
    }
    // Number 0 is the way itself, then come its parts.
    void part(const Todo& at) {
        const Node& n = all_.nodes[at.node];
        const Way& way = n.ways[at.way];
        if (at.part == 0) {
            if (!way.text.empty()) line(at.indent, place_of(way) + way.text + (way.catom ? fmt::format("  at @{}", *way.catom) : ""));
            if (!way.note.empty()) line(at.indent + (way.text.empty() ? 0 : 1), way.note);
        }
        if (at.part < way.parts.size()) {
            todo_.push_back({at.node, at.way, at.part + 1, at.indent});
            const Part& p = way.parts[at.part];
            if (p.node && p.is != Part::Is::Fails) {
                push_node(*p.node, at.indent + 1);
            } else {
                const char* const mark = p.is == Part::Is::Fails ? "FAILS  " : p.is == Part::Is::Absent ? "no  " : "";
                line(at.indent + 1,
                     mark + p.text + (p.tick ? fmt::format("  in tick {}", *p.tick) : "") + (p.note.empty() ? "" : "  " + p.note));
                if (p.node) push_node(*p.node, at.indent + 2);
            }
        } else if (at.way + 1 == n.ways.size()) {
            tail(n, at.indent);
        }
    }

    const Explanation& all_;
    std::vector<bool> shown_;
    std::vector<Todo> todo_;
    std::string out_;
};

std::string dot_text(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        out += c;
    }
    return out + "\"";
}

}  // namespace

void Explanation::mark_circles() {
    enum class Seen { No, Open, Done };
    std::vector<Seen> seen(nodes.size(), Seen::No);
    struct At {
        std::size_t node, way, part;
    };
    for (const std::size_t root : roots) {
        std::vector<At> path;
        const auto open = [&](std::size_t n) {
            seen[n] = Seen::Open;
            path.push_back({n, 0, 0});
        };
        if (seen[root] == Seen::No) open(root);
        while (!path.empty()) {
            At& at = path.back();
            Node& n = nodes[at.node];
            if (at.way == n.ways.size()) {
                seen[at.node] = Seen::Done;
                path.pop_back();
                continue;
            }
            if (at.part == n.ways[at.way].parts.size()) {
                at = {at.node, at.way + 1, 0};
                continue;
            }
            Part& part = n.ways[at.way].parts[at.part++];
            if (!part.node) continue;
            if (seen[*part.node] == Seen::Open) {
                part.note = "in a circle";
                nodes[*part.node].note = "it rests on itself among the values that hold: one that has been replaced began it";
            } else if (seen[*part.node] == Seen::No) {
                open(*part.node);
            }
        }
    }
}

std::string Explanation::to_text() const { return Lines(*this).take(); }

Json Explanation::to_json() const {
    Json list = Json::array();
    for (const Node& n : nodes) {
        Json node = {{"fact", n.fact}, {"is", name_of(n.is)}, {"tick", n.tick}};
        if (n.rank != kAbsent) node["rank"] = n.rank;
        if (!n.note.empty()) node["note"] = n.note;
        Json ways = Json::array();
        for (const Way& w : n.ways) {
            Json parts = Json::array();
            for (const Part& p : w.parts) {
                Json part = {{"is", name_of(p.is)}, {"text", p.text}};
                if (p.node) part["node"] = *p.node;
                if (p.tick) part["tick"] = *p.tick;
                if (!p.note.empty()) part["note"] = p.note;
                parts.push_back(std::move(part));
            }
            Json way = Json::object();
            if (!w.text.empty()) way = {{"rule", w.rule}, {"text", w.text}, {"file", w.file}, {"line", w.line}};
            if (w.catom) way["catom"] = *w.catom;
            if (!w.note.empty()) way["note"] = w.note;
            if (!w.with.empty()) way["with"] = Json::object();
            for (const auto& [variable, value] : w.with) way["with"][variable] = value;
            way["parts"] = std::move(parts);
            ways.push_back(std::move(way));
        }
        node["ways"] = std::move(ways);
        if (n.more > 0) node["more"] = n.more;
        if (!n.others.empty()) node["others"] = n.others;
        list.push_back(std::move(node));
    }
    Json out = {{"tick", tick}, {"asked", asked}, {"roots", roots}, {"nodes", std::move(list)}};
    if (more > 0) out["more"] = more;
    return out;
}

std::string Explanation::to_dot() const {
    std::string out = "digraph why {\n  node [shape=box];\n";
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const Node& n = nodes[i];
        std::string label = n.fact + (n.tick != tick ? fmt::format(" in tick {}", n.tick) : "");
        if (n.is != Node::Is::Derived) label += fmt::format(" ({})", name_of(n.is));
        out += fmt::format("  n{} [label={}{}];\n", i, dot_text(label), n.is == Node::Is::Missing ? ", style=dashed" : "");
        for (std::size_t w = 0; w < n.ways.size(); ++w) {
            const Way& way = n.ways[w];
            if (way.parts.empty() && way.text.empty()) continue;
            out += fmt::format("  n{}w{} [shape=plain, label={}];\n  n{} -> n{}w{};\n", i, w, dot_text(place_of(way) + way.text), i, i, w);
            for (std::size_t p = 0; p < way.parts.size(); ++p) {
                const Part& part = way.parts[p];
                const char* const style = part.is == Part::Is::Fails ? " [style=dashed]" : "";
                if (part.node) {
                    out += fmt::format("  n{}w{} -> n{}{};\n", i, w, *part.node, style);
                    continue;
                }
                const std::string text = (part.is == Part::Is::Absent ? "no " : "") + part.text;
                out += fmt::format("  n{}w{}p{} [shape=plain, label={}];\n  n{}w{} -> n{}w{}p{}{};\n", i, w, p, dot_text(text), i, w, i, w,
                                   p, style);
            }
        }
    }
    return out + "}\n";
}

}  // namespace meld::inspect
