// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include <fmt/format.h>

#include "apps/octant/commands.h"
#include "apps/octant/outputs.h"
#include "apps/octant/steps/steps.h"
#include "io/deployment/signature.h"
#include "io/text/atomic_file.h"
#include "io/text/bounds.h"

namespace octant::app {
namespace {

struct SignArgs {
  std::string deployment, key, output, new_key;
};

int new_key(const SignArgs& words, Session& session) {
  if (!words.deployment.empty() || !words.key.empty() || !words.output.empty())
    return session.fail(
        {"error", "usage", kUsage, "--new-key makes a key and signs nothing", "octant sign --help explains"});
  if (auto made = io::make_key(words.new_key); !made) return session.fail(made.error());
  session.result(fmt::format("{:<17}{}: keep it, and to yourself\n{:<17}{}.pub: for those who check\n",
                             "secret key", words.new_key, "public key", words.new_key));
  return session.finish({{"secret_key", words.new_key}, {"public_key", words.new_key + ".pub"}});
}

int sign(const SignArgs& words, Session& session) {
  if (!words.new_key.empty()) return new_key(words, session);
  if (words.deployment.empty() || words.key.empty() || words.output.empty())
    return session.fail({"error", "usage", kUsage,
                         "expected DEPLOYMENT.json, --key KEY and -o SIGNED.json, or --new-key FILE",
                         "octant sign --help explains"});
  if (words.output == "-" && session.options.json)
    return session.fail(
        {"error", "usage", kUsage, "only one of -o - and --json can have standard output", ""});
  if (words.output == "-") session.result_to_stderr();
  CommandFiles files{.inputs = {words.deployment, words.key}, .outputs = {words.output}, .run_outputs = {}};
  if (auto fit = check_no_overwriting(files); !fit) return session.fail(fit.error());
  if (auto fit = check_output(words.output); !fit) return session.fail(fit.error());
  const auto text = io::read_document(words.deployment);
  if (!text) return session.fail(text.error());
  const auto signed_text = io::signed_deployment(*text, words.deployment, words.key);
  if (!signed_text) return session.fail(signed_text.error());
  if (auto written = io::write_file(words.output, *signed_text); !written)
    return session.fail(written.error());
  session.result(fmt::format("{:<17}{}\n", "signed", words.output));
  return session.finish({{"deployment", words.deployment}, {"written", words.output}});
}

int verify_signature(const SignArgs& words, Session& session) {
  const auto text = io::read_document(words.deployment);
  if (!text) return session.fail(text.error());
  if (auto genuine = io::check_signature(*text, words.deployment, words.key); !genuine)
    return session.fail(genuine.error());
  session.result(
      fmt::format("{:<17}{} is as the owner of {} signed it\n", "genuine", words.deployment, words.key));
  return session.finish({{"deployment", words.deployment}, {"key", words.key}, {"genuine", true}});
}

}  // namespace

void add_sign(CLI::App& app, CommonOptions& common, Action& action) {
  auto words = std::make_shared<SignArgs>();
  CLI::App* command = add_command(app, common, "sign", "Sign a deployment, or make a key to sign with",
                                  "octant sign --new-key site.key\n  octant sign hall/deployment.json --key "
                                  "site.key -o hall/signed.json");
  command->add_option("deployment", words->deployment, "Deployment file, from calibrate")
      ->type_name("DEPLOYMENT.json");
  command->add_option("--key", words->key, "Secret Ed25519 key, PEM")->type_name("KEY");
  command->add_option("-o,--output", words->output, "Signed deployment to write; - is standard output")
      ->type_name("SIGNED.json");
  command
      ->add_option("--new-key", words->new_key,
                   "Instead: make a secret key, and FILE.pub for those who check")
      ->type_name("FILE");
  command->callback(
      [words, &action] { action = [words](Session& session) { return sign(*words, session); }; });
}

void add_verify_signature(CLI::App& app, CommonOptions& common, Action& action) {
  auto words = std::make_shared<SignArgs>();
  CLI::App* command = add_command(app, common, "verify-signature",
                                  "Tell whether a deployment is as the owner of a key signed it",
                                  "octant verify-signature hall/signed.json --key site.key.pub");
  command->add_option("deployment", words->deployment, "Signed deployment")
      ->required()
      ->type_name("DEPLOYMENT.json");
  command->add_option("--key,--trusted-key", words->key, "Public Ed25519 key, PEM")
      ->required()
      ->type_name("PUB");
  command->callback(
      [words, &action] { action = [words](Session& session) { return verify_signature(*words, session); }; });
}

}  // namespace octant::app
