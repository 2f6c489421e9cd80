"""The classic GPT model in closed form, flat and nested, and how a model is driven offline in a few lines."""

import pytest
from devs_stories import coupled, run
from heavylift.nodes.devs import Tag, seconds
from heavylift.nodes.zoo import Generator, Processor, Transducer, workshop


@pytest.mark.parametrize("nested", [False, True])
def test_a_processor_model_completes_four_of_eleven_generated_jobs(nested: bool) -> None:
    if nested:
        model = workshop(seconds(1), seconds(2.5), seconds(10))
        t = model.children["frame"].children["transducer"]
    else:
        g, p, t = Generator("g", seconds(1)), Processor("p", seconds(2.5)), Transducer("t", seconds(10))
        model = coupled("gpt", [g, p, t])
        for source, target in [(g.job, p.into), (g.job, t.arrived), (p.done, t.solved), (t.stop, g.stop)]:
            model.connect(source, target)
    run(model, 100)
    assert (t.arrivals, t.solutions, t.last) == (11, 4, Tag(seconds(11.5)))
    assert (t.solutions / t.arrivals, t.solutions / (t.last.t / 1e9)) == (4 / 11, 4 / 11.5)
