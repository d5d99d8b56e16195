"""`diffwhitted schema`: what a scene file may hold."""

import json


def schema() -> None:
    """Print the JSON Schema of scene files, for editors and for programs that write them.

    \b
    diffwhitted schema > scene.schema.json
    """
    from diffwhitted.formats import scene_schema

    print(json.dumps(scene_schema(), indent=2, ensure_ascii=False))
