// A program compiled for a processor that is nowhere: see processor_check.hpp.
#include "app/processor_check.hpp"

const unsigned moraine::processor_needs = 1u << 31;

int main() {
    return 0;
}
