#include "balance/zoltan.hpp"

#include <mpi.h>
#include <zoltan.h>

#include <algorithm>
#include <string>

#include "balance/block_graph.hpp"
#include "core/data/error.hpp"

namespace moraine {
namespace {

/// Particles that cost as much to move as a tile costs to send once: about 200 B against 60 nodes of 64 B.
constexpr std::int64_t particles_per_tile = 20;

/// What the callbacks look at.
struct Question {
    const Layout& layout;
    std::span<const BlockLoad> blocks;
    int parts;
    BlockGraph graph;  ///< phg alone
};

const Question& asked(void* data) {
    return *static_cast<const Question*>(data);
}

int count_blocks(void* data, int* error) {
    *error = ZOLTAN_OK;
    return static_cast<int>(asked(data).blocks.size());
}

void list_blocks(void* data, int, int, ZOLTAN_ID_PTR ids, ZOLTAN_ID_PTR, int, float* weights, int* error) {
    const Question& q = asked(data);
    for (std::size_t b = 0; b < q.blocks.size(); ++b) {
        ids[b] = static_cast<ZOLTAN_ID_TYPE>(b);
        weights[b] = static_cast<float>(q.blocks[b].weight);
    }
    *error = ZOLTAN_OK;
}

int count_axes(void* data, int* error) {
    *error = ZOLTAN_OK;
    return asked(data).layout.dimensions;
}

void place_blocks(void* data, int, int, int count, ZOLTAN_ID_PTR ids, ZOLTAN_ID_PTR, int axes, double* x, int* error) {
    const Question& q = asked(data);
    for (int k = 0; k < count; ++k) {
        const Position at = block_position(q.layout, q.blocks[ids[k]].key);
        for (int a = 0; a < axes; ++a) x[k * axes + a] = at[a];
    }
    *error = ZOLTAN_OK;
}

void count_nets(void* data, int* nets, int* pins, int* format, int* error) {
    const Question& q = asked(data);
    *nets = static_cast<int>(q.blocks.size());
    *pins = static_cast<int>(q.graph.neighbour.size() + q.blocks.size());
    *format = ZOLTAN_COMPRESSED_EDGE;
    *error = ZOLTAN_OK;
}

void list_nets(void* data, int, int nets, int, int, ZOLTAN_ID_PTR ids, int* first, ZOLTAN_ID_PTR pins, int* error) {
    const BlockGraph& graph = asked(data).graph;
    int pin = 0;
    for (int b = 0; b < nets; ++b) {
        ids[b] = static_cast<ZOLTAN_ID_TYPE>(b);
        first[b] = pin;
        pins[pin++] = static_cast<ZOLTAN_ID_TYPE>(b);
        for (std::int64_t k = graph.first[b]; k < graph.first[b + 1]; ++k)
            pins[pin++] = static_cast<ZOLTAN_ID_TYPE>(graph.neighbour[k]);
    }
    *error = ZOLTAN_OK;
}

void list_parts(void* data, int, int, int count, ZOLTAN_ID_PTR ids, ZOLTAN_ID_PTR, int* parts, int* error) {
    const Question& q = asked(data);
    for (int k = 0; k < count; ++k) parts[k] = q.blocks[ids[k]].owner;
    *error = ZOLTAN_OK;
}

void size_blocks(void* data, int, int, int count, ZOLTAN_ID_PTR ids, ZOLTAN_ID_PTR, int* sizes, int* error) {
    const Question& q = asked(data);
    for (int k = 0; k < count; ++k) sizes[k] = 1 + static_cast<int>(q.blocks[ids[k]].particles / particles_per_tile);
    *error = ZOLTAN_OK;
}

/// Zoltan's C structure.
class Handle {
  public:
    Handle() {
        float version = 0;
        check(Zoltan_Initialize(0, nullptr, &version), "start");
        zoltan_ = Zoltan_Create(MPI_COMM_SELF);
        if (!zoltan_) check(ZOLTAN_MEMERR, "start");
    }
    ~Handle() { Zoltan_Destroy(&zoltan_); }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;

    Zoltan_Struct* get() const { return zoltan_; }
    void set(const char* name, const std::string& value) {
        check(Zoltan_Set_Param(zoltan_, name, value.c_str()), name);
    }

    static void check(int code, const char* where) {
        if (code != ZOLTAN_OK && code != ZOLTAN_WARN)
            throw MachineError("Zoltan failed at " + std::string(where) + " (code " + std::to_string(code) +
                               "). Use balance.partitioner = \"hilbert\"?");
    }

  private:
    Zoltan_Struct* zoltan_ = nullptr;
};

void set_common(Handle& zoltan, Question& q) {
    zoltan.set("DEBUG_LEVEL", "0");  // first: other settings would be announced on stdout
    zoltan.set("SEED", "1");
    zoltan.set("NUM_GID_ENTRIES", "1");
    zoltan.set("NUM_LID_ENTRIES", "0");
    zoltan.set("OBJ_WEIGHT_DIM", "1");
    zoltan.set("NUM_GLOBAL_PARTS", std::to_string(q.parts));
    zoltan.set("RETURN_LISTS", "PARTS");
    zoltan.set("REMAP", "0");  // parts are given to ranks afterwards
    zoltan.set("IMBALANCE_TOL", "1.01");
    Zoltan_Set_Num_Obj_Fn(zoltan.get(), count_blocks, &q);
    Zoltan_Set_Obj_List_Fn(zoltan.get(), list_blocks, &q);
    Zoltan_Set_Num_Geom_Fn(zoltan.get(), count_axes, &q);
    Zoltan_Set_Geom_Multi_Fn(zoltan.get(), place_blocks, &q);
}

void set_phg(Handle& zoltan, Question& q, int steps) {
    q.graph = graph_of(q.layout, q.blocks);
    if (q.graph.first.back() + static_cast<std::int64_t>(q.blocks.size()) > INT32_MAX)
        throw InputError("balance.partitioner = \"phg\" (its 32 bits cannot count " +
                         std::to_string(q.graph.first.back()) + " neighbours). Use hilbert?");
    zoltan.set("HYPERGRAPH_PACKAGE", "PHG");
    zoltan.set("PHG_EDGE_SIZE_THRESHOLD", "1.0");  // no net is dropped for its size, with a warning
    Zoltan_Set_HG_Size_CS_Fn(zoltan.get(), count_nets, &q);
    Zoltan_Set_HG_CS_Fn(zoltan.get(), list_nets, &q);
    const bool all_held = std::all_of(q.blocks.begin(), q.blocks.end(), [&](const BlockLoad& block) {
        return block.owner >= 0 && block.owner < q.parts;
    });
    zoltan.set("LB_APPROACH", all_held ? "REPARTITION" : "PARTITION");
    if (!all_held) return;
    zoltan.set("PHG_REPART_MULTIPLIER", std::to_string(steps));
    Zoltan_Set_Part_Multi_Fn(zoltan.get(), list_parts, &q);
    Zoltan_Set_Obj_Size_Multi_Fn(zoltan.get(), size_blocks, &q);
}

}  // namespace

bool zoltan_is_built() {
    return true;
}

std::vector<std::int32_t> zoltan_parts(ZoltanMethod method, const Layout& layout, int steps,
                                       std::span<const BlockLoad> blocks, int parts) {
    Question q{layout, blocks, parts, {}};
    Handle zoltan;
    set_common(zoltan, q);
    zoltan.set("LB_METHOD", method == ZoltanMethod::rcb ? "RCB" : method == ZoltanMethod::hsfc ? "HSFC" : "HYPERGRAPH");
    if (method == ZoltanMethod::phg) set_phg(zoltan, q, steps);

    int changes = 0, id_words = 0, local_words = 0, incoming = 0, listed = 0;
    ZOLTAN_ID_PTR incoming_ids = nullptr, incoming_local = nullptr, ids = nullptr, local = nullptr;
    int *from = nullptr, *into = nullptr, *to = nullptr, *part = nullptr;
    const int code = Zoltan_LB_Partition(zoltan.get(), &changes, &id_words, &local_words, &incoming, &incoming_ids,
                                         &incoming_local, &from, &into, &listed, &ids, &local, &to, &part);
    std::vector<std::int32_t> result(blocks.size(), -1);
    for (int k = 0; k < listed; ++k) result[ids[k]] = part[k];
    Zoltan_LB_Free_Part(&incoming_ids, &incoming_local, &from, &into);
    Zoltan_LB_Free_Part(&ids, &local, &to, &part);
    Handle::check(code, "partitioning");
    const bool complete = std::all_of(result.begin(), result.end(), [&](int p) { return p >= 0 && p < parts; });
    if (!complete) Handle::check(ZOLTAN_FATAL, "partitioning: a block has no part");
    return result;
}

}  // namespace moraine
