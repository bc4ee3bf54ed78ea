"""`gimbal-hil point --certify`: drawn flights with errors of navigation, put together as a terminal maker needs it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

CERTIFICATE_FILE, PAGE_FILE = "certificate.json", "report.html"


@dataclass(frozen=True)
class CertifyChoice:
    """What the command line chose."""

    flights: int
    duration_s: float
    config: Path | None
    model: str | None
    navigation: Path | None
    seed: int
    workers: int
    folder: Path
    resume: bool
    as_json: bool


def certify(choice: CertifyChoice) -> int:
    """Fly, write page and JSON, and say what counts; exit code 1 where the requirement is not kept."""
    import json
    import sys
    import time

    from firmware_protocol.errors import EXIT_DONE, EXIT_INTERRUPTED, EXIT_NO
    from gimbal_hil.pages.report import Page
    from gimbal_hil.pointing.certifying import (
        FlightTask,
        FlownFile,
        FlownFlight,
        NavigationErrors,
        PointingRequirement,
        certificate_blocks,
        certificate_document,
        certified,
        load_navigation,
        summary,
    )
    from gimbal_hil.surface.cli.antenna_choice import settings_and_antenna
    from gimbal_hil.surface.cli.following import after_certificate
    from gimbal_hil.surface.cli.next_line import print_next
    from gimbal_hil.surface.cli.progress import ProgressBar

    settings, antenna = settings_and_antenna(choice.config, choice.model)
    navigation = NavigationErrors() if choice.navigation is None else load_navigation(choice.navigation)
    task = FlightTask(settings.with_model(), antenna, navigation, PointingRequirement(), choice.duration_s)
    file = FlownFile(choice.folder, task, choice.resume)

    def done(flights: list[FlownFlight]) -> None:
        file.keep(flights)
        bar.at("flights", len(flights))

    try:
        with ProgressBar() as bar:
            bar.begin("flights", choice.flights, min(len(file.kept), choice.flights))
            found = certified(task, choice.flights, choice.seed, choice.workers, time.monotonic, done, file.kept)
    except KeyboardInterrupt:
        print(f"interrupted; the same command with --out {choice.folder} --resume goes on", file=sys.stderr)
        return EXIT_INTERRUPTED
    document = certificate_document(found, antenna.name)
    (choice.folder / CERTIFICATE_FILE).write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    title = f"Pointing certificate of {antenna.name}"
    page = Page(title, f"{choice.flights} drawn flights", certificate_blocks(found)).write(choice.folder / PAGE_FILE)
    if choice.as_json:
        print(json.dumps(document, allow_nan=False))
    else:
        print(summary(found))
        print(f"  report  {page}")
        words: dict[str, object] = dict(config=choice.config, model=choice.model, navigation=choice.navigation)
        words |= dict(duration=f"{choice.duration_s:g}", seed=choice.seed, workers=choice.workers)
        print_next(after_certificate(choice.flights, choice.folder, choice.config, words))
    return EXIT_DONE if found.keeps else EXIT_NO
