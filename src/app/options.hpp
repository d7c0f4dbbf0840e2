#pragma once
// The command line: what to do, with which scene, and how; nothing about the physics but --set.

#include <string>
#include <vector>

#include "replay/replay_options.hpp"

namespace moraine {

struct Options {
    std::string command;  ///< run, check, kernels, replay, schema, version, help
    std::string topic;    ///< of help: a command; empty: all
    std::string scene;    ///< path
    std::string output;   ///< directory; empty: runs/<scene name>
    bool overwrite = false;
    std::vector<std::string> sets;   ///< KEY=VALUE
    bool allow_code = false;         ///< laws in files are compiled and run
    std::string device = "auto";     ///< cpu, cuda, auto
    std::string transport = "auto";  ///< auto, or one of comm/transport_names.hpp
    std::string kernel_cache;        ///< folder of compiled kernels and laws; empty: the user's, none: nothing is kept
    std::vector<int> architectures;  ///< kernels: compute capabilities times 10; empty: that of the build
    std::string partitioner;         ///< empty: the scene's
    std::string restart;             ///< checkpoint; empty: from the start
    std::vector<std::string> allow_changes;  ///< keys in which the scene may differ from the checkpoint's
    std::string trace;                       ///< file for the timeline of all ranks; empty: none
    bool quiet = false;
    bool no_particles = false;  ///< outputs are the records alone, without particles.vtkhdf
    int ranks = 1;              ///< check: to predict memory for
    bool time = false;          ///< check: step for a second
    ReplayOptions replay;
};

/// Throws InputError. Not collective: every rank has the same arguments.
Options parse_options(int argc, const char* const* argv);

/// What --help prints of a command; empty: of all.
std::string help_text(const std::string& topic);

}  // namespace moraine
