// METIS (Karypis and Kumar, "A fast and high quality multilevel scheme for partitioning irregular graphs", SIAM J. Sci. Comput. 1998).
#include "runtime/world/graph/divide.h"

#include <metis.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <limits>
#include <string_view>

#include "runtime/base/assert.h"
#include "runtime/base/terminal/log.h"

namespace meld::graph {
namespace {

constexpr idx_t kSeed = 1;

// Where there are more links than METIS can count, or it fails: nodes in order, with about the same work in each part.
std::vector<std::int32_t> in_order(const Graph& graph, int parts) {
    std::vector<std::int32_t> out(graph.nodes());
    const double all = static_cast<double>(graph.nodes() + graph.to.size());
    for (Node node = 0; node < graph.nodes(); ++node) {
        const double before = static_cast<double>(node + graph.first[node]);
        out[node] = std::min(parts - 1, static_cast<int>(before / all * parts));
    }
    return out;
}

// What METIS says on stderr while this lives. It leaves by SIGTERM where it fails, and says why before that; so a SIGTERM of somebody
// else is one without a word. Nobody else may write to stderr then.
class Complaint {
  public:
    Complaint() : stream_(fmemopen(text_.data(), text_.size() - 1, "w")) {
        if (stream_ == nullptr) return;
        // Then nothing is allocated while it speaks, be it because memory is short.
        std::setvbuf(stream_, nullptr, _IONBF, 0);
        stderr = stream_;
    }
    ~Complaint() {
        if (stream_ == nullptr) return;
        stderr = before_;
        std::fclose(stream_);
    }
    Complaint(const Complaint&) = delete;
    Complaint& operator=(const Complaint&) = delete;

    // Its first line.
    std::string_view text() const {
        const std::string_view all = text_.data();
        return all.substr(0, all.find('\n'));
    }

  private:
    std::array<char, 512> text_{};
    std::FILE* before_ = stderr;
    std::FILE* stream_;
};

}  // namespace

std::vector<std::int32_t> divide(const Graph& graph, int parts) {
    MELD_EXPECT(parts > 0, "{} parts", parts);
    const std::uint64_t nodes = graph.nodes();
    if (parts == 1) return std::vector<std::int32_t>(nodes, 0);
    if (nodes < 4 * static_cast<std::uint64_t>(parts) || graph.to.size() > std::numeric_limits<idx_t>::max()) return in_order(graph, parts);
    std::vector<idx_t> first(graph.first.begin(), graph.first.end()), to(graph.to.begin(), graph.to.end()), weights(nodes), part(nodes);
    for (Node node = 0; node < nodes; ++node) weights[node] = static_cast<idx_t>(1 + graph.degree(node));
    idx_t n = static_cast<idx_t>(nodes), constraints = 1, wanted = parts, links_cut = 0;
    idx_t options[METIS_NOPTIONS];
    METIS_SetDefaultOptions(options);
    options[METIS_OPTION_SEED] = kSeed;
    options[METIS_OPTION_NUMBERING] = 0;
    const Complaint complaint;
    const int done = METIS_PartGraphKway(&n, &constraints, first.data(), to.data(), weights.data(), nullptr, nullptr, &wanted, nullptr,
                                         nullptr, options, &links_cut, part.data());
    if (done == METIS_OK) return {part.begin(), part.end()};
    // While it runs, METIS takes SIGTERM for an error of its own. Who has sent it meant the process.
    if (done == METIS_ERROR && complaint.text().empty())
        std::raise(SIGTERM);
    else
        log::warning("METIS cannot divide the graph ({}): its nodes are divided in order, by which more links may lead to other processes",
                     complaint.text().empty() ? "it does not say why" : complaint.text());
    return in_order(graph, parts);
}

std::uint64_t cut(const Graph& graph, const std::vector<std::int32_t>& part) {
    std::uint64_t count = 0;
    for (Node node = 0; node < graph.nodes(); ++node)
        for (const Node other : graph.neighbours(node)) count += node < other && part[node] != part[other] ? 1 : 0;
    return count;
}

}  // namespace meld::graph
