#include "accuracy/measure.ipp"

namespace moraine {
template Measured measure<float>(const AccuracyCase&, const Configuration&, int);
}
