#pragma once
// summary.json: what a run was and did, in the order in which it is told.
//
// A value is nothing (null), a truth, a number, text, a list or named values. JSON has no NaN and no
// infinity: they become null. Numbers read back to the same bits.

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "comm/comm.hpp"

namespace moraine {

class Json {
  public:
    using List = std::vector<Json>;
    using Named = std::vector<std::pair<std::string, Json>>;

    Json() = default;
    Json(bool value) : value_(value) {}
    Json(int value) : value_(std::int64_t(value)) {}
    Json(std::int64_t value) : value_(value) {}
    Json(double value) : value_(value) {}
    Json(const char* text) : value_(std::string(text)) {}
    Json(std::string text) : value_(std::move(text)) {}
    Json(List list) : value_(std::move(list)) {}
    Json(Named named) : value_(std::move(named)) {}
    template <class T>
    Json(const std::vector<T>& list) : value_(List(list.begin(), list.end())) {}

    /// As text, two blanks an indent.
    std::string text(int indent = 0) const;

  private:
    std::variant<std::monostate, bool, std::int64_t, double, std::string, List, Named> value_;
};

/// `path` holds the old content or all of the new at any moment. MachineError on all ranks if the disk
/// fails. Collective; rank 0's content counts.
void write_summary(const Comm& comm, const std::string& path, const Json& summary);

}  // namespace moraine
