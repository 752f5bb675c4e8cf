#include "runtime/world/graph/files.h"

#include <gtest/gtest.h>

namespace meld::graph {
namespace {

Result<Graph> read(const std::string& name, const std::string& text, std::optional<bool> directed = std::nullopt,
                   const std::optional<std::string>& nodes = std::nullopt) {
    if (!nodes) return read_graph({name, text}, std::nullopt, directed);
    return read_graph({name, text}, FileText{"nodes.csv", *nodes}, directed);
}

Graph graph(const std::string& name, const std::string& text, std::optional<bool> directed = std::nullopt,
            const std::optional<std::string>& nodes = std::nullopt) {
    Result<Graph> out = read(name, text, directed, nodes);
    EXPECT_TRUE(out.has_value()) << (out ? "" : out.error().message());
    return out ? std::move(*out) : Graph();
}

// "0-1 1-2", by the numbers of the nodes.
std::string links(const Graph& graph) {
    std::string out;
    for (Node n = 0; n < graph.nodes(); ++n)
        for (std::uint64_t at = graph.first[n]; at < graph.first[n + 1]; ++at)
            if (graph.directed ? graph.leads(at) : n < graph.to[at])
                out += (out.empty() ? "" : " ") + std::to_string(graph.id(n)) + (graph.directed ? ">" : "-") +
                       std::to_string(graph.id(graph.to[at]));
    return out;
}

TEST(GraphFiles, ListsMayHaveCommasTabsBlanksCommentsAndNames) {
    const char* texts[] = {"0,1\n1,2\n",
                           "from,to\n0,1\n1,2\n",
                           "# a comment\n% another\n\n0 1\n1   2\n",
                           "# FromNodeId\tToNodeId\n0\t1\r\n1\t2\r\n",
                           "Source;Target\n0;1\n1;2",
                           "\"x\",\"y\"\n\"0\", \"1\"\n\"1\",\"2\"\n",
                           "0 1 {}\n1 2 {}\n"};
    for (const char* text : texts) {
        const Graph g = graph("edges.csv", text);
        EXPECT_EQ(links(g), "0-1 1-2") << text;
        EXPECT_TRUE(g.ids.empty()) << text;
        EXPECT_TRUE(g.warnings.empty()) << text;
    }
}

TEST(GraphFiles, NumbersOfNodesStayWhatTheyAre) {
    const Graph gaps = graph("edges.txt", "1 5\n5 9\n");
    EXPECT_EQ(links(gaps), "1-5 5-9");
    EXPECT_EQ(gaps.nodes(), 3u);
    EXPECT_EQ(gaps.next_id(), 10u);
    EXPECT_EQ(gaps.find(9), 2u);
    EXPECT_EQ(gaps.find(2), std::nullopt);
    EXPECT_EQ(links(graph("edges.txt", "1000000000000 5\n")), "5-1000000000000");
}

TEST(GraphFiles, WordsGetNumbersInTheirOrder) {
    const Graph g = graph("edges.csv", "bob,alice\nalice,carol\n");
    EXPECT_EQ(links(g), "0-1 1-2");
    ASSERT_EQ(g.node_columns.size(), 1u);
    EXPECT_EQ(g.node_columns[0].name, "name");
    EXPECT_EQ(g.node_columns[0].text(1), "\"alice\"");
    // A first line of well-known names is none of words.
    EXPECT_EQ(graph("edges.csv", "source,target\nbob,alice\n").nodes(), 2u);
}

TEST(GraphFiles, QuotesInsideWordsTellThemApart) {
    const Graph g = graph("edges.csv",
                          "\xEF\xBB\xBF"
                          "from,to,\"a \"\"b\"\"\"\na,\"san \"\"f\"\"\",1\na,\"san \"\"g\"\"\",2\n",
                          {}, "node,\"x, y\"\na,1\n\"san \"\"f\"\"\",2\n\"san \"\"g\"\"\",3\n");
    EXPECT_EQ(links(g), "0-1 0-2");
    EXPECT_EQ(g.columns[0].name, "a \"b\"");
    ASSERT_EQ(g.node_columns.size(), 2u);
    EXPECT_EQ(g.node_columns[0].name, "x, y");
    EXPECT_EQ(std::get<2>(g.node_columns[1].values)[1], "san \"f\"");
    EXPECT_EQ(std::get<2>(g.node_columns[1].values)[2], "san \"g\"");
}

TEST(GraphFiles, ColumnsKeepTheirTypes) {
    const Graph g = graph("edges.csv", "from,to,weight,length,road\n0,1,3,0.5,A1\n1,2,-4,2,\"B, 2\"\n");
    ASSERT_EQ(g.columns.size(), 3u);
    EXPECT_EQ(g.columns[0].name, "weight");
    EXPECT_EQ(g.columns[0].text(1), "-4");
    EXPECT_EQ(g.columns[1].text(0), "0.5");
    EXPECT_EQ(g.columns[1].text(1), "2.0");
    EXPECT_EQ(g.columns[2].text(1), "\"B, 2\"");
    EXPECT_EQ(graph("edges.txt", "0 1 7\n").columns[0].name, "weight");
    // A column that begins with whole numbers.
    EXPECT_EQ(graph("edges.txt", "0 1 7\n1 2 7.5\n").columns[0].text(0), "7.0");
    EXPECT_EQ(graph("edges.txt", "0 1 7\n1 2 x\n").columns[0].text(0), "\"7\"");
}

TEST(GraphFiles, DoubledLinksAndLoopsAreReported) {
    const Graph g = graph("edges.csv", "0,1\n1,0\n1,1\n1,2\n2,2\n");
    EXPECT_EQ(links(g), "0-1 1-2");
    ASSERT_EQ(g.warnings.size(), 2u);
    EXPECT_EQ(g.warnings[0], "edges.csv:3: this and 1 more links join a node with itself and are left out");
    EXPECT_EQ(g.warnings[1], "edges.csv: 1 of 3 links are listed more than once and count once");
    EXPECT_TRUE(graph("edges.csv", "0,1\n1,0\n", true).warnings.empty());
    EXPECT_EQ(links(graph("edges.csv", "0,1\n1,0\n2,1\n", true)), "0>1 1>0 2>1");
}

TEST(GraphFiles, NodesHaveColumnsAndPlaces) {
    const Graph g = graph("edges.csv", "0,1\n", {}, "node,x,y,level\n1,2.5,1,8\n0,0,0,9\n4,1,1,7\n");
    EXPECT_EQ(g.nodes(), 3u);
    EXPECT_EQ(g.id(2), 4u);
    EXPECT_EQ(g.places, (std::vector<Point>{{0, 0}, {2.5, 1}, {1, 1}}));
    EXPECT_EQ(g.node_columns[2].name, "level");
    EXPECT_EQ(g.node_columns[2].text(0), "9");
    const Graph words = graph("edges.csv", "a,b\n", {}, "name,level\nb,1\na,2\nc,3\n");
    EXPECT_EQ(words.nodes(), 3u);
    EXPECT_EQ(words.node_columns[0].text(0), "2");
}

TEST(GraphFiles, MatrixMarket) {
    const Graph g = graph("a.mtx", "%%MatrixMarket matrix coordinate real symmetric\n% x\n4 4 3\n2 1 0.5\n3 2 1\n3 3 9\n");
    EXPECT_EQ(links(g), "0-1 1-2");
    EXPECT_EQ(g.nodes(), 4u);
    EXPECT_EQ(g.columns[0].text(0), "0.5");
    EXPECT_EQ(g.warnings.size(), 1u);
    EXPECT_EQ(links(graph("a.mtx", "%%MatrixMarket matrix coordinate pattern general\n2 2 2\n1 2\n2 1\n", true)), "0>1 1>0");
}

TEST(GraphFiles, NodeLinkForm) {
    const char* text =
        R"({"directed": true, "multigraph": false, "graph": {}, "nodes": [{"id": 0, "x": 1, "y": 2}, {"id": 1, "x": 3, "y": 4},
                          {"id": 7, "x": 0, "y": 0}], "links": [{"weight": 5, "source": 0, "target": 1}]})";
    const Graph g = graph("g.json", text);
    EXPECT_EQ(links(g), "0>1");
    EXPECT_EQ(g.nodes(), 3u);
    EXPECT_EQ(g.columns[0].text(0), "5");
    EXPECT_EQ(g.places[2], (Point{0, 0}));
    EXPECT_EQ(links(graph("g.json", text, false)), "0-1");
    EXPECT_EQ(links(graph("g.json", R"({"nodes": [{"id": "a"}, {"id": "b"}], "edges": [{"source": "b", "target": "a"}]})")), "0-1");
}

TEST(GraphFiles, MistakesHaveTheirPlace) {
    struct Case {
        const char *name, *text, *message;
    };
    const Case wrong[] = {
        {"e.csv", "", "e.csv lists no links"},
        {"e.csv", "from,to\n", "e.csv lists no links"},
        {"e.csv", "0,b\n", "e.csv:1:3: 'b' is a word, and the nodes before are numbers. write all nodes as numbers"},
        {"e.csv", "0,1\n1,x\n", "e.csv:2:3: 'x' is a word, and the nodes before are numbers. write all nodes as numbers"},
        {"e.csv", "0,1\n1,-2\n", "e.csv:2:3: -2 is no node. number nodes from 0"},
        {"e.csv", "0,1\n1\n", "e.csv:2:1: '1' is no link"},
        {"e.csv", "0,1\n1,2,3\n", "e.csv:2:1: here are 3 fields, and the first line has 2. give each link the same columns"},
        {"e.csv", "0,1\n1,\n", "e.csv:2:3: here is no node"},
        {"e.csv", "0,1,3\n2,1,3\n1,0,4\n",
         "e.csv:3: this link is listed in e.csv:1 already, with another weight. take one of them out, or write"},
        {"e.csv", "0 99999999999999999999\n", "e.csv:1:3"},
        {"e.csv", "a,b\na,\"b\n", "e.csv:2:3: this quote is not closed. end the field with a quote on the same line"},
        {"e.csv", "a,\"b\n", "e.csv:1:3: this quote is not closed"},
        {"e.csv", "a,b\na,\"b\"c\n", "e.csv:2:6: text follows the quote that ends a field. write a quote inside a quoted field twice"},
        {"e.csv", "a,b\na,b\"c\"\n", "e.csv:2:4: a quote inside a field that does not begin with one. put the whole field in quotes"},
        {"a.mtx", "%%MatrixMarket matrix coordinate pattern general\n2 2 1\n1 \"2\n", "a.mtx:3:3: this quote is not closed"},
        {"e.txt", "0 1 {'weight': \"b\"c}\n", "networkx.write_edgelist(G, path, data=[\"weight\"])"},
        {"e.txt", "0 1 {'weight': 3}\n", "networkx.write_edgelist(G, path, data=[\"weight\"])"},
        {"g.graphml", "<graphml/>", "json.dump(networkx.node_link_data(G), file)"},
        {"a.mtx", "1 2\n", "a.mtx:1: this is no Matrix Market file"},
        {"a.mtx", "%%MatrixMarket matrix array real general\n", "a.mtx:1: a matrix in array form has no links"},
        {"a.mtx", "%%MatrixMarket matrix coordinate pattern general\n2 3 1\n1 2\n", "a.mtx:2: a matrix of 2 rows and 3 columns"},
        {"a.mtx", "%%MatrixMarket matrix coordinate pattern general\n2 2 1\n1 3\n", "a.mtx:3: entry 1 3 is not in a matrix of 2 rows"},
        {"a.mtx", "%%MatrixMarket matrix coordinate pattern general\n2 2 2\n1 2\n", "the file is cut off or damaged"},
        {"g.json", "{", "g.json:1:2: this is no JSON: it ends too early. the file is cut off: write it again"},
        {"g.json", "", "g.json:1:1: this is no JSON: it ends too early"},
        {"g.json", "{\n  \"nodes\": [,]}", "g.json:2:13: this is no JSON. write it with json.dump"},
        {"g.json", "{\"nodes\": [{\"id\": 0, \"x\": NaN}]}", "g.json:1:27: \"x\" is NaN, which is no number of JSON. give it a number"},
        {"g.json", "{\"links\": [\n {\"weight\" : -Infinity}]}", "g.json:2:14: \"weight\" is -Infinity, which is no number of JSON"},
        {"g.json", "[1, Infinity]", "g.json:1:5: a value is Infinity, which is no number of JSON"},
        {"g.json", "[NaN]", "json.dump(networkx.node_link_data(G), file, allow_nan=False) refuses such values"},
        {"g.json", "[]", "g.json is no graph in node-link form"},
        {"g.json", R"({"nodes": [{"id": 0}, {"id": 0}], "links": []})", "node 0 is listed twice"},
        {"g.json", R"({"nodes": [{"id": 0}], "links": [{"source": 0, "target": 3}]})", "the target of link 0 is 3, which is no node"},
        {"g.json", R"({"nodes": [{"id": 0, "x": 1}, {"id": 1}], "links": []})", "node 1 has other attributes than the first one"},
    };
    for (const auto& [name, text, message] : wrong) {
        const Result<Graph> out = read(name, text);
        ASSERT_FALSE(out.has_value()) << text;
        EXPECT_NE(out.error().message().find(message), std::string::npos) << text << "\n" << out.error().message();
    }
    const std::pair<const char*, const char*> wrong_nodes[] = {
        {"node,x\n0,1\n", "e.csv:1: nodes.csv does not list node 1. list all nodes, or none"},
        {"node,x\n0,1\n0,1\n", "nodes.csv:3:1: node 0 is listed already, in line 2"},
        {"0,1\n1,1\n", "nodes.csv:1:1: the first line does not name the columns"},
        {"node,x\n0,1\n1\n", "nodes.csv:3:1: here are 1 fields, and the first line names 2"},
        {"node,x\na,1\n", "nodes.csv:2:1: 'a' is no node"},
        {"node,x\n0,1\n\"1,1\n", "nodes.csv:3:1: this quote is not closed"},
        {"node,\"x\n0,1\n", "nodes.csv:1:6: this quote is not closed"},
    };
    for (const auto& [nodes, message] : wrong_nodes) {
        const Result<Graph> out = read("e.csv", "0,1\n", {}, nodes);
        ASSERT_FALSE(out.has_value()) << nodes;
        EXPECT_NE(out.error().message().find(message), std::string::npos) << nodes << "\n" << out.error().message();
    }
}

}  // namespace
}  // namespace meld::graph
