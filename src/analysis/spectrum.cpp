#include "amb_rotor/analysis/spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>
#include <unsupported/Eigen/FFT>

#include "argument.hpp"

namespace amb_rotor {
namespace {

using Complex = std::complex<double>;

struct Segments {
  std::size_t length = 0;
  std::vector<std::size_t> start;
};

Segments segmentsOf(std::size_t count, const SpectrumOptions& options) {
  requireArgument(options.overlap >= 0.0 && options.overlap < 1.0, "overlap", options.overlap,
                  "must be in [0, 1)");
  Segments segments;
  segments.length = options.segment_length == 0 ? count : options.segment_length;
  if (segments.length < 2 || segments.length > count) return segments;
  const auto step = std::max<std::size_t>(
      1, static_cast<std::size_t>(std::lround((1.0 - options.overlap) * segments.length)));
  for (std::size_t at = 0; at + segments.length <= count; at += step) segments.start.push_back(at);
  return segments;
}

/// Line amplitudes of one segment on the FFT's own order of lines.
class SegmentTransform {
 public:
  SegmentTransform(std::size_t length, const SpectrumOptions& options)
      : remove_mean_(options.remove_mean), window_(windowValues(options.window, length)), buffer_(length) {
    const double sum = std::accumulate(window_.begin(), window_.end(), 0.0);
    double squares = 0.0;
    for (double w : window_) squares += w * w;
    scale_ = 1.0 / sum;
    noise_bandwidth_ = length * squares / (sum * sum);
  }

  double noiseBandwidth() const { return noise_bandwidth_; }

  std::vector<double> magnitude(const std::vector<double>& x, const std::vector<double>& y,
                                std::size_t start) {
    Complex mean = 0.0;
    for (std::size_t i = 0; i < buffer_.size(); ++i) {
      buffer_[i] = Complex(x[start + i], y.empty() ? 0.0 : y[start + i]);
      mean += buffer_[i];
    }
    mean = remove_mean_ ? mean / static_cast<double>(buffer_.size()) : Complex(0.0);
    for (std::size_t i = 0; i < buffer_.size(); ++i) buffer_[i] = (buffer_[i] - mean) * window_[i];
    std::vector<Complex> lines;
    fft_.fwd(lines, buffer_);
    std::vector<double> result(lines.size());
    for (std::size_t i = 0; i < lines.size(); ++i) result[i] = std::abs(lines[i]) * scale_;
    return result;
  }

 private:
  bool remove_mean_;
  std::vector<double> window_;
  std::vector<Complex> buffer_;
  double scale_ = 1.0, noise_bandwidth_ = 1.0;
  Eigen::FFT<double> fft_;
};

void checkSignal(const std::vector<double>& signal, const char* name) {
  for (double value : signal) requireArgument(std::isfinite(value), name, value, "must be finite");
}

std::vector<double> frequencyAxis(std::size_t length, double sample_rate, bool full) {
  const double step = sample_rate / length;
  std::vector<double> frequency;
  if (full) {
    for (std::size_t i = 0; i < length; ++i) {
      frequency.push_back(step * (static_cast<double>(i) - static_cast<double>(length / 2)));
    }
  } else {
    for (std::size_t i = 0; i <= length / 2; ++i) frequency.push_back(step * i);
  }
  return frequency;
}

/// From the FFT's order of lines to the frequency axis.
std::vector<double> arranged(const std::vector<double>& lines, bool full) {
  const std::size_t n = lines.size();
  std::vector<double> result;
  if (full) {
    for (std::size_t i = 0; i < n; ++i) result.push_back(lines[(i + n - n / 2) % n]);
  } else {
    for (std::size_t i = 0; i <= n / 2; ++i) {
      const bool single = i == 0 || 2 * i == n;
      result.push_back(single ? lines[i] : 2.0 * lines[i]);
    }
  }
  return result;
}

Spectrum spectrumOf(const std::vector<double>& x, const std::vector<double>& y, double sample_rate, bool full,
                    const SpectrumOptions& options) {
  requireArgument(sample_rate > 0.0 && std::isfinite(sample_rate), "sample_rate", sample_rate,
                  "must be above 0 [Hz]");
  checkSignal(x, "x");
  checkSignal(y, "y");
  const Segments segments = segmentsOf(x.size(), options);
  Spectrum spectrum;
  spectrum.window = options.window;
  spectrum.segments = segments.start.size();
  if (segments.start.empty()) return spectrum;
  SegmentTransform transform(segments.length, options);
  spectrum.resolution = sample_rate / segments.length;
  spectrum.noise_bandwidth = transform.noiseBandwidth();
  spectrum.frequency = frequencyAxis(segments.length, sample_rate, full);
  spectrum.amplitude.assign(spectrum.frequency.size(), 0.0);
  for (std::size_t start : segments.start) {
    const std::vector<double> lines = arranged(transform.magnitude(x, y, start), full);
    for (std::size_t i = 0; i < lines.size(); ++i) spectrum.amplitude[i] += lines[i] * lines[i];
  }
  for (double& value : spectrum.amplitude) value = std::sqrt(value / segments.start.size());
  return spectrum;
}

SpectralPeak refined(const Spectrum& s, std::size_t k) {
  const double here = s.amplitude[k], before = s.amplitude[k - 1], after = s.amplitude[k + 1];
  double shift = 0.0, amplitude = here;
  if (s.window == Window::hann) {
    // A single tone between two lines: ratio r = A(k+1)/A(k), shift (2 r - 1)/(r + 1).
    const double ratio = std::max(before, after) / here;
    const double size = (2.0 * ratio - 1.0) / (ratio + 1.0);
    if (size > 0.0) {
      shift = after > before ? size : -size;
      const double angle = M_PI * size;
      amplitude = here * angle * (1.0 - size * size) / std::sin(angle);
    }
  } else if (before > 0.0 && after > 0.0) {
    const double a = std::log(before), b = std::log(here), c = std::log(after);
    const double curvature = a - 2.0 * b + c;
    if (curvature < 0.0) {
      shift = 0.5 * (a - c) / curvature;
      amplitude = std::exp(b - 0.25 * (a - c) * shift);
    }
  }
  return {s.frequency[k] + shift * s.resolution, amplitude};
}

}  // namespace

std::vector<double> windowValues(Window window, std::size_t n) {
  std::vector<double> coefficients = {1.0};
  switch (window) {
    case Window::rectangular:
      break;
    case Window::hann:
      coefficients = {0.5, 0.5};
      break;
    case Window::hamming:
      coefficients = {0.54, 0.46};
      break;
    case Window::blackman:
      coefficients = {0.42, 0.5, 0.08};
      break;
    case Window::flat_top:
      coefficients = {0.21557895, 0.41663158, 0.277263158, 0.083578947, 0.006947368};
      break;
  }
  std::vector<double> values(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    double sign = 1.0;
    for (std::size_t c = 0; c < coefficients.size(); ++c, sign = -sign) {
      values[i] += sign * coefficients[c] * std::cos(2.0 * M_PI * c * i / n);
    }
  }
  return values;
}

Spectrum amplitudeSpectrum(const std::vector<double>& signal, double sample_rate,
                           const SpectrumOptions& options) {
  return spectrumOf(signal, {}, sample_rate, false, options);
}

Spectrum fullSpectrum(const std::vector<double>& x, const std::vector<double>& y, double sample_rate,
                      const SpectrumOptions& options) {
  requireSameLength(x, y, "y");
  return spectrumOf(x, y, sample_rate, true, options);
}

std::vector<SpectralPeak> spectralPeaks(const Spectrum& spectrum, std::size_t max_count,
                                        double least_amplitude) {
  std::vector<SpectralPeak> peaks;
  const std::vector<double>& a = spectrum.amplitude;
  for (std::size_t k = 1; k + 1 < a.size(); ++k) {
    if (a[k] >= least_amplitude && a[k] > a[k - 1] && a[k] >= a[k + 1]) peaks.push_back(refined(spectrum, k));
  }
  std::sort(peaks.begin(), peaks.end(),
            [](const SpectralPeak& p, const SpectralPeak& q) { return p.amplitude > q.amplitude; });
  if (peaks.size() > max_count) peaks.resize(max_count);
  return peaks;
}

Waterfall waterfall(const std::vector<double>& x, const std::vector<double>& y, double sample_rate,
                    const SpectrumOptions& options, const std::vector<double>& speed, double start_time) {
  requireArgument(options.segment_length >= 2, "segment_length", static_cast<double>(options.segment_length),
                  "must be at least 2 samples");
  requireArgument(sample_rate > 0.0 && std::isfinite(sample_rate), "sample_rate", sample_rate,
                  "must be above 0 [Hz]");
  const bool full = !y.empty();
  if (full) requireSameLength(x, y, "y");
  if (!speed.empty()) requireSameLength(x, speed, "speed");
  checkSignal(x, "x");
  checkSignal(y, "y");
  const Segments segments = segmentsOf(x.size(), options);
  Waterfall result;
  if (segments.start.empty()) return result;
  result.frequency = frequencyAxis(segments.length, sample_rate, full);
  SegmentTransform transform(segments.length, options);
  for (std::size_t start : segments.start) {
    WaterfallLine line;
    line.time = start_time + (start + 0.5 * (segments.length - 1)) / sample_rate;
    if (!speed.empty()) {
      line.speed = std::accumulate(speed.begin() + start, speed.begin() + start + segments.length, 0.0) /
                   segments.length;
    }
    line.amplitude = arranged(transform.magnitude(x, y, start), full);
    result.lines.push_back(std::move(line));
  }
  return result;
}

Waterfall cascade(const std::vector<Spectrum>& spectra, const std::vector<double>& speed) {
  requireArgument(spectra.size() == speed.size(), "speed", static_cast<double>(speed.size()),
                  "must have one value a spectrum");
  Waterfall result;
  for (std::size_t i = 0; i < spectra.size(); ++i) {
    if (i == 0) result.frequency = spectra[i].frequency;
    requireArgument(spectra[i].frequency == result.frequency, "spectra", static_cast<double>(i),
                    "must all have the frequency axis of the first");
    WaterfallLine line;
    line.speed = speed[i];
    line.amplitude = spectra[i].amplitude;
    result.lines.push_back(std::move(line));
  }
  std::stable_sort(result.lines.begin(), result.lines.end(),
                   [](const WaterfallLine& a, const WaterfallLine& b) { return a.speed < b.speed; });
  return result;
}

}  // namespace amb_rotor
