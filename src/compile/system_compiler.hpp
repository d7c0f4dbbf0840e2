#pragma once
// The system's C++ compiler: what CXX names, else c++. It makes a shared object of a text and of headers that travel in
// the program, in a folder of its own that is gone afterwards. Options are those of the host's code: the same formulas
// give the same bits.

#include <string>
#include <vector>

#include "compile/source_bundle.hpp"
#include "core/data/error.hpp"

namespace moraine {

/// A compiler refuses a law; its words have lines. The input is wrong, too.
struct CompilerError : InputError {
    using InputError::InputError;
};

class SystemCompiler {
  public:
    /// Throws InputError where there is none.
    SystemCompiler();

    /// Where it is, its size and its date: another one has another.
    const std::string& identity() const { return identity_; }

    /// For this processor (core/data/processor.hpp).
    static std::vector<std::string> options();

    /// The bytes of the shared object. Throws CompilerError with the compiler's words; InputError.
    std::string compile(const std::string& text, const SourceBundle& headers) const;

  private:
    std::vector<std::string> command_;
    std::string identity_;
};

}  // namespace moraine
