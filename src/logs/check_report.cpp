#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "logs/check.h"

namespace wheel_twin::logs {
namespace {

nlohmann::json number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

const char* name_of(Severity severity) {
  return severity == Severity::error ? "error" : "warning";
}

}  // namespace

std::string to_text(const CheckReport& report) {
  std::string text = fmt::format("{}: {}\n", report.file, report.fit() ? "fit for use" : "NOT fit for use");
  for (const TopicSummary& topic : report.topics)
    text += fmt::format("  {:<24} {:>7} messages, {:.4g} Hz, {:.2f} to {:.2f} s\n", topic.topic,
                        topic.messages, topic.rate, topic.start, topic.end);
  for (const Finding& finding : report.findings) {
    text += fmt::format("  {}: {}{}{}", name_of(finding.severity), finding.topic,
                        finding.topic.empty() ? "" : ": ", finding.text);
    text += fmt::format(" ({} time{}", finding.count, finding.count == 1 ? "" : "s");
    if (std::isfinite(finding.first_time)) text += fmt::format(", first at {:.3f} s", finding.first_time);
    text += ")\n";
  }
  return text;
}

std::string to_json(const std::vector<CheckReport>& reports) {
  nlohmann::json logs = nlohmann::json::array();
  bool fit = true;
  for (const CheckReport& report : reports) {
    nlohmann::json log{{"file", report.file}, {"fit", report.fit()}, {"epoch", report.epoch}};
    log["topics"] = nlohmann::json::array();
    for (const TopicSummary& topic : report.topics)
      log["topics"].push_back({{"topic", topic.topic},
                               {"messages", topic.messages},
                               {"rate", number(topic.rate)},
                               {"start", topic.start},
                               {"end", topic.end}});
    log["findings"] = nlohmann::json::array();
    for (const Finding& finding : report.findings)
      log["findings"].push_back({{"severity", name_of(finding.severity)},
                                 {"kind", finding.kind},
                                 {"topic", finding.topic},
                                 {"count", finding.count},
                                 {"first_time", number(finding.first_time)},
                                 {"text", finding.text}});
    fit = fit && report.fit();
    logs.push_back(std::move(log));
  }
  const nlohmann::json all{{"fit", fit}, {"logs", std::move(logs)}};
  // A damaged bag may name a topic with bytes that are no UTF-8: they are replaced.
  return all.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace wheel_twin::logs
