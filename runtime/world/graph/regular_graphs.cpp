#include "runtime/world/graph/generators.h"

namespace meld::graph {

Links line(Node n) {
    Links out;
    out.reserve(n);
    for (Node i = 1; i < n; ++i) out.push_back({i - 1, i});
    return out;
}

Links ring(Node n) {
    Links out = line(n);
    if (n > 2) out.push_back({n - 1, 0});
    return out;
}

Links star(Node n) {
    Links out;
    out.reserve(n);
    for (Node i = 1; i < n; ++i) out.push_back({0, i});
    return out;
}

Links complete(Node n) {
    Links out;
    out.reserve(std::size_t{n} * (n > 0 ? n - 1 : 0) / 2);
    for (Node i = 0; i < n; ++i)
        for (Node k = i + 1; k < n; ++k) out.push_back({i, k});
    return out;
}

Links grid(Node w, Node h, Node d, bool closed) {
    Links out;
    out.reserve(std::size_t{w} * h * d * (d > 1 ? 3 : 2));
    const auto at = [&](Node x, Node y, Node z) { return x + w * (y + h * z); };
    for (Node z = 0; z < d; ++z)
        for (Node y = 0; y < h; ++y)
            for (Node x = 0; x < w; ++x) {
                const Node here = at(x, y, z);
                if (x + 1 < w) out.push_back({here, here + 1});
                if (y + 1 < h) out.push_back({here, at(x, y + 1, z)});
                if (z + 1 < d) out.push_back({here, at(x, y, z + 1)});
                if (!closed) continue;
                if (x + 1 == w && w > 2) out.push_back({here, at(0, y, z)});
                if (y + 1 == h && h > 2) out.push_back({here, at(x, 0, z)});
                if (z + 1 == d && d > 2) out.push_back({here, at(x, y, 0)});
            }
    return out;
}

Links hypercube(int dimensions) {
    Links out;
    const Node n = Node{1} << dimensions;
    out.reserve(std::size_t{n} / 2 * static_cast<std::size_t>(dimensions));
    for (Node i = 0; i < n; ++i)
        for (int bit = 0; bit < dimensions; ++bit)
            if ((i >> bit & 1) == 0) out.push_back({i, i | Node{1} << bit});
    return out;
}

Links tree(Node n, Node children) {
    Links out;
    out.reserve(n);
    for (Node i = 1; i < n; ++i) out.push_back({(i - 1) / children, i});
    return out;
}

}  // namespace meld::graph
